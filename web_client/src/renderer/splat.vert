#version 300 es
// The function of docs/numerics.md: evaluates time, projects a splat and spans a triangle around its ellipse. The numbers
// of layout.ts are defined behind the first line (LAYOUT_DEFINITIONS).
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform sampler2D statics;    // STATIC_TEXELS texels per splat
uniform sampler2D dynamics;   // DYNAMIC_TEXELS texels per splat
uniform sampler2D fifth;      // FIFTH_TEXELS texels per dynamic splat, if any moves in the fifth order
uniform usampler2D order;     // splat ids, farthest first
uniform uint count;           // number of ids
uniform mat3 rotation;        // world to camera
uniform vec3 translation;
uniform vec2 focal;           // pixels
uniform vec2 centre;          // principal point, pixels from the top left
uniform vec2 size;            // picture, pixels
uniform vec2 origin;          // its lower left corner in the framebuffer, pixels
uniform float time;           // normalised time of the segment
uniform float near;           // world units
uniform bool antialiased;
uniform vec4 magnification;   // (a, b, c, d): shown (a x + b y + c z + d) / z times as large as in the pictures of the scene
uniform float still;          // factor of the opacity of static splats
uniform vec2 closeUp;         // depth of the farthest fading splat, world units; deviation at which fading begins, pixels
uniform bool depths;          // draw depths (world units) instead of colours

flat out vec2 middle;         // pixels of the framebuffer
flat out vec3 falloff;        // 1 / (deviation of x given y), slope of x on y, 1 / (deviation of y); times BASE
flat out vec4 colour;         // rgb, log2 of the opacity

#ifdef SURROUNDED
// Defined by code that is appended to this file where splats are drawn among other things (host/host_surface.vert). It
// may change gl_Position.z and colour; p is the splat's centre in camera space, paint its own colour.
void surround(vec3 p, vec3 paint);
#endif

const float VISIBLE = 1.0 / 255.0;
const float LARGEST = 1e18;   // pixels squared; wider splats would overflow
const float FAINTEST = 0.005 * 0.005;
const float BASE = 0.84932180;  // sqrt(log2(e) / 2): exp(-d^2 / 2) is exp2(-(BASE d)^2)
// A triangle around the unit circle: 30 % more pixels than a square, and half the work to set up.
const vec2 CORNERS[3] = vec2[](vec2(-1.7320508, -1.0), vec2(1.7320508, -1.0), vec2(0.0, 2.0));

ivec2 place(int i) { return ivec2(i & (TEXTURE_WIDTH - 1), i >> TEXTURE_BITS); }

mat3 rotationOf(vec4 q) {     // w, x, y, z
  float squared = dot(q, q);
  q = squared < 1e-24 ? vec4(1.0, 0.0, 0.0, 0.0) : q * inversesqrt(squared);
  float w = q.x, x = q.y, y = q.z, z = q.w;
  return mat3(
    1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
    2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
    2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
}

void main() {
  gl_Position = vec4(0.0, 0.0, 2.0, 1.0);   // outside: drawn nowhere
  middle = vec2(0.0);
  falloff = vec3(0.0);
  colour = vec4(0.0);

  uint rank = uint(gl_InstanceID) * TRIANGLES_PER_INSTANCE + uint(gl_VertexID / 3);
  if (rank >= count) return;
  uint id = texelFetch(order, place(int(rank)), 0).r;

  vec3 position;
  vec4 quaternion;
  vec3 sigma;
  vec4 paint;
  if (id >= DYNAMIC_BIT) {
    int splat = int(id - DYNAMIC_BIT);
    ivec2 at = place(splat * DYNAMIC_TEXELS);
    vec4 a = texelFetch(dynamics, at, 0);
    vec4 b = texelFetch(dynamics, at + ivec2(1, 0), 0);
    vec4 c = texelFetch(dynamics, at + ivec2(2, 0), 0);
    vec4 turn0 = texelFetch(dynamics, at + ivec2(3, 0), 0);
    vec4 turn1 = texelFetch(dynamics, at + ivec2(4, 0), 0);
    vec4 e = texelFetch(dynamics, at + ivec2(5, 0), 0);
    vec4 f = texelFetch(dynamics, at + ivec2(6, 0), 0);
    vec2 g = texelFetch(dynamics, at + ivec2(7, 0), 0).xy;
    float d = time - f.w;
    vec3 cubic = c.yzw;
    if (g.y > 0.0) {
      at.x = splat * FIFTH_TEXELS & (FIFTH_WIDTH - 1);   // in the same row
      cubic += d * (texelFetch(fifth, at, 0).xyz + d * texelFetch(fifth, at + ivec2(1, 0), 0).xyz);
    }
    position = a.xyz + d * (vec3(a.w, b.xy) + d * (vec3(b.zw, c.x) + d * cubic));
    quaternion = turn0 + d * turn1;
    sigma = e.xyz;
    paint = vec4(f.xyz, e.w * exp(-g.x * d * d));
  } else {
    ivec2 at = place(int(id) * STATIC_TEXELS);
    vec4 a = texelFetch(statics, at, 0);
    position = a.xyz;
    quaternion = texelFetch(statics, at + ivec2(1, 0), 0);
    sigma = texelFetch(statics, at + ivec2(2, 0), 0).xyz;
    paint = vec4(texelFetch(statics, at + ivec2(3, 0), 0).xyz, still * a.w);
  }

  vec3 p = rotation * position + translation;
  if (p.z < near) return;
  vec2 uv = p.xy / p.z;
  vec2 margin = 0.15 * size / focal;        // 0.3 tan of half the field of view
  vec2 w = clamp(uv, -centre / focal - margin, (size - centre) / focal + margin);
  mat3 m = rotation * rotationOf(quaternion);
  m = mat3(m[0] * sigma.x, m[1] * sigma.y, m[2] * sigma.z);
  vec3 rowZ = vec3(m[0].z, m[1].z, m[2].z);
  vec3 jx = (focal.x / p.z) * (vec3(m[0].x, m[1].x, m[2].x) - w.x * rowZ);
  vec3 jy = (focal.y / p.z) * (vec3(m[0].y, m[1].y, m[2].y) - w.y * rowZ);
  float larger = max(1.0, (dot(magnification.xyz, p) + magnification.w) / p.z);
  float lowPass = LOW_PASS * larger * larger;
  float xx = dot(jx, jx) + lowPass;
  float xy = dot(jx, jy);
  float yy = dot(jy, jy) + lowPass;
  if (!(xx <= LARGEST && yy <= LARGEST)) return;
  // The determinants without and with the low-pass, expanded: xx * yy - xy * xy cancels for long thin splats.
  vec3 area = cross(jx, jy);
  float sharp = dot(area, area);
  float determinant = sharp + lowPass * (dot(jx, jx) + dot(jy, jy)) + lowPass * lowPass;
  if (antialiased) paint.a *= sqrt(max(FAINTEST, sharp / determinant));
  float half_ = 0.5 * (xx - yy);
  float radius = length(vec2(half_, xy));
  float major = 0.5 * (xx + yy) + radius;
  if (p.z < closeUp.x) paint.a *= (p.z - near) / (closeUp.x - near);
  paint.a *= clamp(2.0 - sqrt(major) / closeUp.y, 0.0, 1.0);
  if (!(paint.a >= VISIBLE)) return;

  // The ellipse on which alpha falls to 1/255, spanned along its own axes: fewer pixels than its upright box.
  float reach = sqrt(2.0 * log(255.0 * paint.a));
  float minor = determinant / major;
  vec2 axis = half_ >= 0.0 ? vec2(half_ + radius, xy) : vec2(xy, radius - half_);
  float norm = length(axis);
  axis = norm > 0.0 ? axis / norm : vec2(1.0, 0.0);
  vec2 corner = CORNERS[gl_VertexID % 3];
  vec2 offset = reach * (corner.x * sqrt(major) * axis + corner.y * sqrt(minor) * vec2(-axis.y, axis.x));

  vec2 mean2d = focal * uv + centre;
  middle = origin + vec2(mean2d.x, size.y - mean2d.y);
  falloff = vec3(BASE * sqrt(yy / determinant), xy / yy, BASE * inversesqrt(yy));
  colour = vec4(depths ? vec3(p.z) : paint.rgb, log2(paint.a));
  vec2 clip = 2.0 * (mean2d + offset) / size - 1.0;
  gl_Position = vec4(clip.x, -clip.y, 0.0, 1.0);
#ifdef SURROUNDED
  surround(p, paint.rgb);
#endif
}
