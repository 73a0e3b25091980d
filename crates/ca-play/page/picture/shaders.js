// Shaders of the picture. Positions are in textures, with four numbers per mass and 1024 masses per row, and each
// vertex fetches the data it needs. So each view is uploaded once for masses and links, and a frame between two views
// uploads nothing. Masses are discs shaded as spheres. Links are strips with edges smoothed by coverage.

const COMMON = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
uniform sampler2D rest, early, late, colours;
uniform mat4 view, projection;
uniform vec2 size;                // of the picture [px of the device]
uniform float share;              // of the later view
uniform vec2 factor;              // of displacements: on a line, in space
uniform float reach;
uniform vec3 amounts;             // 1 / peak of speed × interval, 1 / peak of displacement, mode
uniform vec4 ground;              // colour of the ground, strength of fading with depth
uniform vec2 depths;              // where fading begins, and over how much
vec4 at(sampler2D t, int i) { return texelFetch(t, ivec2(i & 1023, i >> 10), 0); }
vec3 near(vec3 d) {
  float l = length(d), knee = 0.7 * reach;
  return l <= knee ? d : d * ((knee + 0.3 * reach * (1.0 - exp((knee - l) / (0.3 * reach)))) / l);
}
vec3 tint(vec4 r, vec4 a, vec4 b) {
  bool space = mod(r.w, 2.0) > 0.5;
  vec2 to;
  if (amounts.z < 0.5) to = vec2(pow(clamp(length(b.xyz - a.xyz) * amounts.x, 0.0, 1.0), 0.6), 0.17);
  else if (amounts.z < 1.5) {
    float d = mix(a.w, b.w, share) * amounts.y;
    to = space ? vec2(clamp(d, 0.0, 1.0), 0.17) : vec2(0.5 + 0.5 * sign(d) * pow(min(abs(d), 1.0), 0.7), 0.5);
  } else to = vec2((floor(r.w / 4.0) + 0.5) / 256.0, 0.83);
  return textureLod(colours, to, 0.0).rgb;
}
vec3 place(int i, out vec3 colour) {
  vec4 r = at(rest, i), a = at(early, i), b = at(late, i);
  colour = tint(r, a, b);
  vec3 d = mix(a.xyz, b.xyz, share);
  return r.xyz + (mod(r.w, 2.0) > 0.5 ? d * factor.y : near(d * factor.x));
}
float faded(float depth) { return ground.w * clamp((depth - depths.x) / depths.y, 0.0, 1.0); }
`;

const STRIP = `
vec4 strip(vec4 p, vec4 q, float half_width, out float across, out float along) {
  float least = 1e-4;
  if (p.w < least && q.w < least) return vec4(2.0, 2.0, 2.0, 1.0);
  if (p.w < least) p = mix(q, p, (q.w - least) / (q.w - p.w));
  if (q.w < least) q = mix(p, q, (p.w - least) / (p.w - q.w));
  vec2 a = p.xy / p.w * size * 0.5, b = q.xy / q.w * size * 0.5, d = b - a;
  float l = length(d);
  vec2 t = l > 1e-3 ? d / l : vec2(1.0, 0.0), n = vec2(-t.y, t.x);
  float side = float(gl_VertexID & 1) * 2.0 - 1.0, end = float(gl_VertexID >> 1);
  across = side * (half_width + 1.0);
  along = end * l;
  vec4 c = end < 0.5 ? p : q;
  c.xy += n * across / size * 2.0 * c.w;
  return c;
}`;

const SMOOTH = `
  float cover = clamp(half_width + 0.5 - abs(across), 0.0, 1.0);
  if (dash > 0.0 && mod(along, dash) > 0.5 * dash) cover = 0.0;`;

export const MASS = [COMMON + `
uniform vec3 ball;                // radius [m], least and most [px of the device]
uniform float scale;              // px of the device of a metre at a distance of one
uniform int under;                // mass under the pointer
uniform int held[10];             // masses of the fingers
out vec2 corner; flat out vec4 paint; flat out vec2 about;
void main() {
  int i = gl_InstanceID;
  vec3 colour, p = place(i, colour);
  float flags = at(rest, i).w;
  bool square = mod(floor(flags / 2.0), 2.0) > 0.5;
  vec4 e = view * vec4(p, 1.0);
  float depth = -e.z;
  float px = clamp(ball.x * scale / depth, ball.y, ball.z);
  float mark = i == under ? 1.0 : 0.0;
  for (int k = 0; k < 10; k++) if (i == held[k]) mark = 2.0;
  if (square) px *= 0.7;
  if (mark > 0.5) px = max(px * 1.35, px + 2.0);
  e.z += min(px * depth / scale, 0.5 * depth);
  vec4 c = projection * e;
  float edge = px + 1.5 + (mark > 0.5 ? 5.0 : 0.0);
  corner = (vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0) * edge;
  c.xy += corner / size * 2.0 * c.w;
  gl_Position = depth > 1e-4 ? c : vec4(2.0, 2.0, 2.0, 1.0);
  paint = vec4(mix(colour, ground.rgb, mark > 0.5 ? 0.0 : faded(depth)), square ? 1.0 : 0.0);
  about = vec2(px, mark);
}`, `#version 300 es
precision highp float;
in vec2 corner; flat in vec4 paint; flat in vec2 about;
uniform vec4 ink;
out vec4 result;
void main() {
  float px = about.x, far = paint.w > 0.5 ? max(abs(corner.x), abs(corner.y)) : length(corner);
  float cover = clamp(px + 0.5 - far, 0.0, 1.0), ring = 0.0;
  if (about.y > 0.5) ring = clamp(1.25 - abs(length(corner) - px - 3.5), 0.0, 1.0) * (about.y > 1.5 ? 1.0 : 0.7);
  if (cover + ring < 0.02) discard;
  vec3 c = paint.rgb;
  if (paint.w > 0.5) c = mix(c, ink.rgb, 0.35);
  else if (px > 2.0) {
    vec2 f = corner / px;
    vec3 n = vec3(f, sqrt(max(0.0, 1.0 - dot(f, f))));
    float lit = max(0.0, dot(n, normalize(vec3(-0.45, 0.65, 0.75))));
    float shine = pow(max(0.0, dot(n, normalize(vec3(-0.28, 0.42, 0.87)))), 36.0);
    float depth = smoothstep(2.0, 5.0, px);
    c = mix(c, c * (0.5 + 0.62 * lit) + 0.3 * shine, depth);
  }
  result = vec4(c, 1.0) * cover;
  result += vec4(ink.rgb, 1.0) * ring * (1.0 - result.a);
}`];

export const LINK = [COMMON + STRIP + `
in uvec2 ends;
uniform vec4 line;                // colour of a line, and how much of it is taken from its ends
uniform float half_width;
out float across; out float along; out vec3 paint; out float fade;
void main() {
  vec3 ca, cb, a = place(int(ends.x), ca), b = place(int(ends.y), cb);
  vec4 p = projection * (view * vec4(a, 1.0)), q = projection * (view * vec4(b, 1.0));
  gl_Position = strip(p, q, half_width, across, along);
  bool first = gl_VertexID < 2;
  paint = mix(line.rgb, first ? ca : cb, line.w);
  fade = faded(first ? p.w : q.w);
}`, `#version 300 es
precision highp float;
in float across; in float along; in vec3 paint; in float fade;
uniform float half_width, opacity, dash;
out vec4 result;
void main() {${SMOOTH}
  float a = cover * opacity * (1.0 - fade);
  result = vec4(paint * a, a);
}`];

// wire frame of a unit sphere, as pairs of points
export const WIRE = [COMMON + STRIP + `
in vec3 from, to;
uniform vec4 ball;                // centre, radius
uniform float half_width;
out float across; out float along; out float facing;
void main() {
  vec4 e = view * vec4(ball.xyz + from * ball.w, 1.0), f = view * vec4(ball.xyz + to * ball.w, 1.0);
  gl_Position = strip(projection * e, projection * f, half_width, across, along);
  vec3 middle = (view * vec4(ball.xyz, 1.0)).xyz, here = gl_VertexID < 2 ? e.xyz : f.xyz;
  facing = dot(normalize(here - middle), normalize(-here));
}`, `#version 300 es
precision highp float;
in float across; in float along; in float facing;
uniform vec4 ink;
uniform float half_width, opacity, dash;
out vec4 result;
void main() {${SMOOTH}
  float a = cover * opacity * (0.35 + 0.65 * smoothstep(-0.4, 0.3, facing));
  result = vec4(ink.rgb * a, a);
}`];

// surface of the sphere: a disc with a denser rim, like thin glass
export const SKIN = [COMMON + `
uniform vec4 ball;
uniform float scale;
out vec2 corner;
void main() {
  vec4 e = view * vec4(ball.xyz, 1.0);
  corner = (vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0) * 1.03;
  float d = -e.z, rim = d > ball.w ? d / sqrt(d * d - ball.w * ball.w) : 1.0;
  e.xy += corner * ball.w * rim;
  gl_Position = projection * e;
}`, `#version 300 es
precision highp float;
in vec2 corner;
uniform vec4 ink;
uniform float opacity;
out vec4 result;
void main() {
  float r = length(corner), w = fwidth(r);
  float inside = 1.0 - smoothstep(1.0 - w, 1.0 + w, r);
  float rim = pow(clamp(r, 0.0, 1.0), 6.0), edge = clamp(1.0 - abs(r - 1.0 + w) / (1.2 * w), 0.0, 1.0);
  float lit = 0.06 * smoothstep(0.9, 0.0, length(corner - vec2(-0.38, 0.45)));
  float a = opacity * ((0.045 + 0.16 * rim + lit) * inside + 0.4 * edge);
  result = vec4(ink.rgb * a, a);
}`];
