/** The function of docs/numerics.md as nodes of three.js' shading language: as renderer/splat.vert and splat.frag. */

import {
  clamp,
  cross,
  Discard,
  dot,
  exp,
  exp2,
  Fn,
  float,
  If,
  int,
  inverseSqrt,
  ivec2,
  length,
  log,
  log2,
  max,
  min,
  screenCoordinate,
  select,
  sqrt,
  texture,
  uint,
  uniform,
  varyingProperty,
  vec2,
  vec3,
  vec4,
  vertexIndex,
} from "three/tsl";
import { Matrix3, type Node, type Texture, type TextureNode, Vector2, Vector3, Vector4 } from "three/webgpu";
import {
  DYNAMIC_BIT,
  DYNAMIC_TEXELS,
  FIFTH_TEXELS,
  FIFTH_WIDTH,
  LOW_PASS,
  STATIC_TEXELS,
  TEXTURE_WIDTH,
} from "../renderer/layout";

const VISIBLE = 1 / 255;
const LARGEST = 1e18; // pixels squared
const FAINTEST = 0.005 * 0.005;
const BASE = Math.sqrt(Math.LOG2E / 2); // exp(-d^2 / 2) is exp2(-(BASE d)^2)
const HALF = Math.sqrt(3); // half a side of the triangle around the unit circle

/** The values of a shot, and the textures of the splats: different ones from the beginning, or they would count as one. */
export function splatInputs(statics: Texture, dynamics: Texture, fifth: Texture, order: Texture) {
  return {
    statics: texture(statics),
    dynamics: texture(dynamics),
    fifth: texture(fifth),
    order: texture(order),
    rotation: uniform(new Matrix3()),
    translation: uniform(new Vector3()),
    focal: uniform(new Vector2()),
    centre: uniform(new Vector2()),
    size: uniform(new Vector2()),
    origin: uniform(new Vector2()), // the picture's upper left corner in the target, pixels
    time: uniform(0),
    near: uniform(0),
    antialiased: uniform(0),
    magnification: uniform(new Vector4()),
    still: uniform(1),
    closeUp: uniform(new Vector2()),
    depthZ: uniform(new Vector4()),
    depthW: uniform(new Vector4()),
  };
}

export type SplatInputs = ReturnType<typeof splatInputs>;

const place = (i: Node<"int">) => ivec2(i.bitAnd(TEXTURE_WIDTH - 1), i.shiftRight(Math.log2(TEXTURE_WIDTH)));

/** A texel, without the transformation of textures. */
function load(from: TextureNode, at: Node<"ivec2">): TextureNode {
  const texel = from.load(at);
  texel.updateMatrix = false;
  return texel;
}

/** The axes of a rotation; w, x, y, z. */
function axesOf(quaternion: Node<"vec4">): readonly Node<"vec3">[] {
  const squared = dot(quaternion, quaternion).toVar();
  const unit = select(squared.lessThan(1e-24), vec4(1, 0, 0, 0), quaternion.mul(inverseSqrt(squared))).toVar();
  const [w, x, y, z] = [unit.x, unit.y, unit.z, unit.w];
  const twice = (a: Node<"float">, b: Node<"float">) => a.mul(b).mul(2);
  const rest = (a: Node<"float">, b: Node<"float">) => float(1).sub(a.mul(a).add(b.mul(b)).mul(2));
  return [
    vec3(rest(y, z), twice(x, y).add(twice(w, z)), twice(x, z).sub(twice(w, y))),
    vec3(twice(x, y).sub(twice(w, z)), rest(x, z), twice(y, z).add(twice(w, x))),
    vec3(twice(x, z).add(twice(w, y)), twice(y, z).sub(twice(w, x)), rest(x, y)),
  ];
}

/** The nodes of the splats' material: three vertices a splat, the farthest first. */
export function splatNodes(u: SplatInputs) {
  // These are the same at all vertices of a splat.
  const middle = varyingProperty("vec2", "hgsMiddle");
  const falloff = varyingProperty("vec3", "hgsFalloff");
  const colour = varyingProperty("vec4", "hgsColour");
  const depth = varyingProperty("float", "hgsDepth"); // clip-space w, the host's

  const vertexNode = Fn(() => {
    const id = uint(load(u.order, place(int(vertexIndex.div(uint(3))))).x).toVar();
    const position = vec3(0).toVar();
    const quaternion = vec4(0).toVar();
    const sigma = vec3(0).toVar();
    const paint = vec4(0).toVar();
    If(id.greaterThanEqual(uint(DYNAMIC_BIT)), () => {
      const splat = int(id.sub(uint(DYNAMIC_BIT))).toVar();
      const at = place(splat.mul(DYNAMIC_TEXELS)).toVar();
      const texel = (i: number) => load(u.dynamics, at.add(ivec2(i, 0)));
      const [a, b, c] = [texel(0).toVar(), texel(1).toVar(), texel(2).toVar()];
      const [e, f, g] = [texel(5).toVar(), texel(6).toVar(), texel(7).toVar()];
      const d = u.time.sub(f.w).toVar();
      const cubic = c.yzw.toVar();
      If(g.y.greaterThan(0), () => {
        const column = splat.mul(FIFTH_TEXELS).bitAnd(FIFTH_WIDTH - 1);
        const more = ivec2(column, at.y).toVar(); // the same row
        const fifth = load(u.fifth, more.add(ivec2(1, 0))).xyz.mul(d);
        cubic.addAssign(load(u.fifth, more).xyz.add(fifth).mul(d));
      });
      const steeper = vec3(b.zw, c.x).add(cubic.mul(d));
      position.assign(a.xyz.add(vec3(a.w, b.xy).add(steeper.mul(d)).mul(d)));
      quaternion.assign(texel(3).add(texel(4).mul(d)));
      sigma.assign(e.xyz);
      paint.assign(vec4(f.xyz, e.w.mul(exp(g.x.mul(d).mul(d).negate()))));
    }).Else(() => {
      const at = place(int(id).mul(STATIC_TEXELS)).toVar();
      const texel = (i: number) => load(u.statics, at.add(ivec2(i, 0)));
      const a = texel(0).toVar();
      position.assign(a.xyz);
      quaternion.assign(texel(1));
      sigma.assign(texel(2).xyz);
      paint.assign(vec4(texel(3).xyz, u.still.mul(a.w)));
    });

    const p = u.rotation.mul(position).add(u.translation).toVar();
    const uv = p.xy.div(p.z).toVar();
    const margin = u.size.div(u.focal).mul(0.15); // 0.3 tan of half the field of view
    const left = u.centre.negate().div(u.focal).sub(margin);
    const w = clamp(uv, left, u.size.sub(u.centre).div(u.focal).add(margin)).toVar();
    const scales = [sigma.x, sigma.y, sigma.z];
    const [mx, my, mz] = axesOf(quaternion).map((axis, i) => u.rotation.mul(axis).mul(scales[i]).toVar());
    const rowZ = vec3(mx.z, my.z, mz.z).toVar();
    const jx = vec3(mx.x, my.x, mz.x).sub(rowZ.mul(w.x)).mul(u.focal.x.div(p.z)).toVar();
    const jy = vec3(mx.y, my.y, mz.y).sub(rowZ.mul(w.y)).mul(u.focal.y.div(p.z)).toVar();
    const larger = max(1, dot(u.magnification.xyz, p).add(u.magnification.w).div(p.z)).toVar();
    const lowPass = larger.mul(larger).mul(LOW_PASS).toVar();
    const xx = dot(jx, jx).add(lowPass).toVar();
    const xy = dot(jx, jy).toVar();
    const yy = dot(jy, jy).add(lowPass).toVar();
    // The determinants without and with the low-pass, expanded: xx yy - xy xy cancels for long thin splats.
    const area = cross(jx, jy).toVar();
    const sharp = dot(area, area).toVar();
    const widened = lowPass.mul(dot(jx, jx).add(dot(jy, jy))).add(lowPass.mul(lowPass));
    const determinant = sharp.add(widened).toVar();
    If(u.antialiased.greaterThan(0), () => {
      paint.w.mulAssign(sqrt(max(FAINTEST, sharp.div(determinant))));
    });
    const half = xx.sub(yy).mul(0.5).toVar();
    const radius = length(vec2(half, xy)).toVar();
    const major = xx.add(yy).mul(0.5).add(radius).toVar();
    If(p.z.lessThan(u.closeUp.x), () => {
      paint.w.mulAssign(p.z.sub(u.near).div(u.closeUp.x.sub(u.near)));
    });
    paint.w.mulAssign(clamp(float(2).sub(sqrt(major).div(u.closeUp.y)), 0, 1));

    // The ellipse on which alpha falls to 1/255, spanned along its own axes.
    const reach = sqrt(log(paint.w.mul(255)).mul(2));
    const minor = determinant.div(major);
    const along = select(half.greaterThanEqual(0), vec2(half.add(radius), xy), vec2(xy, radius.sub(half))).toVar();
    const norm = length(along).toVar();
    const axis = select(norm.greaterThan(0), along.div(norm), vec2(1, 0)).toVar();
    const nth = int(vertexIndex.mod(uint(3))).toVar();
    const sideways = select(nth.equal(0), float(-HALF), select(nth.equal(1), float(HALF), float(0)));
    const upwards = select(nth.equal(2), float(2), float(-1));
    const wide = axis.mul(sqrt(major).mul(sideways));
    const narrow = vec2(axis.y.negate(), axis.x).mul(sqrt(minor).mul(upwards));
    const mean = u.focal.mul(uv).add(u.centre).toVar();
    const clip = mean.add(wide.add(narrow).mul(reach)).div(u.size).mul(2).sub(1).toVar();
    const clipW = dot(u.depthW, vec4(p, 1)).toVar();
    middle.assign(u.origin.add(mean));
    falloff.assign(vec3(sqrt(yy.div(determinant)).mul(BASE), xy.div(yy).negate(), inverseSqrt(yy).mul(BASE)));
    colour.assign(vec4(paint.xyz, log2(paint.w)));
    depth.assign(clipW);
    const drawn = p.z
      .greaterThanEqual(u.near)
      .and(xx.lessThanEqual(LARGEST))
      .and(yy.lessThanEqual(LARGEST))
      .and(paint.w.greaterThanEqual(VISIBLE));
    const shown = vec4(clip.x, clip.y.negate(), dot(u.depthZ, vec4(p, 1)).div(clipW), 1);
    return select(drawn, shown, vec4(0, 0, 2, 1)); // outside: drawn nowhere
  })();

  const fragmentNode = Fn(() => {
    const delta = screenCoordinate.sub(middle).toVar();
    const x = falloff.x.mul(delta.x.add(falloff.y.mul(delta.y)));
    const deviations = vec2(x, falloff.z.mul(delta.y)).toVar();
    const power = colour.w.sub(dot(deviations, deviations)).toVar();
    Discard(power.lessThan(Math.log2(VISIBLE)));
    const alpha = min(0.99, exp2(power)).toVar();
    return vec4(colour.xyz.mul(alpha), alpha);
  })();

  return { vertexNode, fragmentNode, depth };
}
