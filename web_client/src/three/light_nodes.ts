/** The conversion of a target's linear light to sRGB and back, around the splats: see linear_light.ts. */

import {
  abs,
  any,
  Fn,
  float,
  greaterThan,
  int,
  max,
  premultiplyAlpha,
  screenUV,
  select,
  sRGBTransferEOTF,
  sRGBTransferOETF,
  texture,
  unpremultiplyAlpha,
  vec2,
  vec4,
  vertexIndex,
} from "three/tsl";
import { FramebufferTexture, NearestFilter, type Node, type WebGPURenderer } from "three/webgpu";

/** Largest relative error of a half float that was rounded twice. */
const ROUNDED = 2 ** -10;

/** A triangle that covers the viewport. */
export const wholeViewport = () =>
  Fn(() => {
    const nth = int(vertexIndex);
    const right = select(nth.equal(1), float(3), float(-1));
    return vec4(vec2(right, select(nth.equal(2), float(3), float(-1))), 0, 1);
  })();

/** A copy of the bound target. */
export class TargetCopy {
  readonly texture = new FramebufferTexture(1, 1);

  constructor() {
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
  }

  take(renderer: WebGPURenderer): void {
    const target = renderer.getRenderTarget();
    const { image } = this.texture;
    const [width, height] = target
      ? [target.width, target.height]
      : [renderer.domElement.width, renderer.domElement.height];
    if (image.width !== width || image.height !== height || (target && this.texture.type !== target.texture.type)) {
      [image.width, image.height] = [width, height];
      this.texture.needsUpdate = true;
    }
    const context = renderer.getContext();
    // Otherwise SwiftShader now and then copies the contents before the host's clearing.
    if (context instanceof WebGL2RenderingContext) context.flush();
    renderer.copyFramebufferToTexture(this.texture);
  }
}

/** Colours multiplied by alpha, converted as three.js converts its picture for the canvas: without alpha. */
function converted(colours: Node<"vec4">, convert: typeof sRGBTransferOETF): Node<"vec4"> {
  const straight = unpremultiplyAlpha(colours).toVar();
  return premultiplyAlpha(vec4(convert(max(straight.xyz, 0)) as Node<"vec3">, straight.w));
}

const srgb = (light: Node<"vec4">) => converted(light, sRGBTransferOETF);

/** The copy in sRGB. */
export const toSrgb = (before: TargetCopy) => Fn(() => srgb(texture(before.texture, screenUV)))();

/** The later copy in linear light; pixels without splats keep the bits of the earlier one. */
export const toLinear = (before: TargetCopy, after: TargetCopy) =>
  Fn(() => {
    const earlier = texture(before.texture, screenUV).toVar();
    const later = texture(after.texture, screenUV).toVar();
    const without = srgb(earlier).toVar();
    const changed = any(greaterThan(abs(later.sub(without)), abs(without).mul(ROUNDED)));
    return select(changed, converted(later, sRGBTransferEOTF), earlier);
  })();
