/** Compiled and linked programs, with the driver's messages as errors. */

function compile(gl: WebGL2RenderingContext, type: number, source: string): WebGLShader {
  const shader = gl.createShader(type);
  if (!shader) throw new Error("the graphics context is lost");
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/** Locations of uniforms; null for unused ones. */
export type Uniforms<Name extends string> = Readonly<Record<Name, WebGLUniformLocation | null>>;

export function uniformsOf<Name extends string>(
  gl: WebGL2RenderingContext,
  program: WebGLProgram,
  names: readonly Name[],
): Uniforms<Name> {
  const uniforms = names.map((name) => [name, gl.getUniformLocation(program, name)]);
  return Object.fromEntries(uniforms) as Uniforms<Name>;
}

export class Program<Name extends string> {
  readonly handle: WebGLProgram;
  readonly uniforms: Uniforms<Name>;

  readonly #gl: WebGL2RenderingContext;

  constructor(gl: WebGL2RenderingContext, vertexSource: string, fragmentSource: string, names: readonly Name[]) {
    this.#gl = gl;
    const vertex = compile(gl, gl.VERTEX_SHADER, vertexSource);
    const fragment = compile(gl, gl.FRAGMENT_SHADER, fragmentSource);
    this.handle = gl.createProgram();
    gl.attachShader(this.handle, vertex);
    gl.attachShader(this.handle, fragment);
    gl.linkProgram(this.handle);
    if (!gl.getProgramParameter(this.handle, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = [gl.getShaderInfoLog(vertex), gl.getShaderInfoLog(fragment), gl.getProgramInfoLog(this.handle)];
      throw new Error(`the shaders do not compile on this device: ${logs.filter(Boolean).join(" ").trim()}`);
    }
    gl.deleteShader(vertex);
    gl.deleteShader(fragment);
    this.uniforms = uniformsOf(gl, this.handle, names);
  }

  dispose(): void {
    this.#gl.deleteProgram(this.handle);
  }
}
