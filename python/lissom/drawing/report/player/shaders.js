// Programs of the graphics card: how light falls on things, thin lines, the ground with its grid and shadow.

const VERSION = "#version 300 es\nprecision highp float;\n";

const LIT_OUT = `
uniform mat4 matrix;
out vec3 place;
out vec3 normal;
out vec4 colour;
`;

/** Skins: vertices with their normals and colours, in axes with a pose. */
const SKIN = `${VERSION}${LIT_OUT}
layout(location = 0) in vec3 point;
layout(location = 1) in vec3 outward;
layout(location = 2) in vec3 paint;
uniform float opacity;
uniform mat4 pose;
void main() {
  place = (pose * vec4(point, 1.0)).xyz;
  normal = mat3(pose) * outward;
  colour = vec4(paint, opacity);
  gl_Position = matrix * vec4(place, 1.0);
}`;

/** Frustums from a to b: shafts and heads of arrows. */
const FRUSTUM = `${VERSION}${LIT_OUT}
layout(location = 0) in vec4 corner;
layout(location = 1) in vec3 a;
layout(location = 2) in vec3 b;
layout(location = 3) in vec2 radii;
layout(location = 4) in vec3 paint;
void main() {
  vec3 along = b - a;
  float size = max(length(along), 1e-30);
  vec3 d = along / size;
  vec3 u = normalize(cross(d, abs(d.z) < 0.7 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
  vec3 side = corner.x * u + corner.y * cross(d, u);
  place = a + corner.z * along + mix(radii.x, radii.y, corner.z) * side;
  normal = corner.w == 0.0 ? normalize(side * size + d * (radii.x - radii.y)) : d * corner.w;
  colour = vec4(paint, 1.0);
  gl_Position = matrix * vec4(place, 1.0);
}`;

/** Ellipsoids and boxes: a unit figure, stretched, turned and placed. */
const FIGURE = `${VERSION}${LIT_OUT}
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 outward;
layout(location = 2) in vec3 centre;
layout(location = 3) in vec4 turn;
layout(location = 4) in vec3 size;
layout(location = 5) in vec4 paint;
vec3 turned(vec3 v) { return v + 2.0 * cross(turn.yzw, cross(turn.yzw, v) + turn.x * v); }
void main() {
  place = centre + turned(size * corner);
  normal = turned(normalize(outward / size));
  colour = paint;
  gl_Position = matrix * vec4(place, 1.0);
}`;

/** Light from over the reader's shoulder, a brighter sky than ground, a soft highlight. */
const LIGHT = `${VERSION}
in vec3 place;
in vec3 normal;
in vec4 colour;
uniform vec3 eye;
uniform vec3 light;
uniform vec3 up;
uniform float isDark;
out vec4 result;
void main() {
  vec3 n = normalize(normal);
  vec3 towards = normalize(eye - place);
  float sky = 0.5 + 0.5 * dot(n, up);
  float diffuse = max(dot(n, light), 0.0);
  float shine = pow(max(dot(n, normalize(light + towards)), 0.0), 48.0);
  float rim = pow(1.0 - max(dot(n, towards), 0.0), 3.0);
  vec3 lit = colour.rgb * (mix(0.5, 0.7, sky) + 0.5 * diffuse) + 0.18 * shine;
  lit = mix(lit, isDark > 0.5 ? lit + 0.14 : lit * 0.78, rim);
  result = vec4(lit, 1.0) * colour.a;
}`;

/** Shadows: darker near the ground. */
const SHADOW = `${VERSION}
in vec3 place;
in vec4 colour;
uniform vec3 up;
uniform float low;
uniform float tall;
out vec4 result;
void main() {
  float height = clamp((dot(place, up) - low) / tall, 0.0, 1.0);
  result = vec4(colour.a * mix(1.0, 0.45, sqrt(height)));
}`;

/** Lines as wide on the screen from near and far. */
const LINE = `${VERSION}
layout(location = 0) in vec2 corner;
layout(location = 1) in vec3 a;
layout(location = 2) in vec3 b;
layout(location = 3) in vec2 way;
uniform mat4 matrix;
uniform vec2 screen;
uniform float width;
out float at;
void main() {
  vec4 p = matrix * vec4(a, 1.0);
  vec4 q = matrix * vec4(b, 1.0);
  vec2 along = normalize((q.xy / q.w - p.xy / p.w) * screen + vec2(1e-6, 0.0));
  vec4 here = corner.x < 0.5 ? p : q;
  here.xy += corner.y * width * vec2(-along.y, along.x) / screen * here.w;
  at = corner.x < 0.5 ? way.x : way.y;
  gl_Position = here;
}`;

const LINE_PAINT = `${VERSION}
in float at;
uniform vec4 paint;
uniform float dash;
out vec4 result;
void main() {
  if (dash > 0.0 && fract(at / dash) > 0.55) discard;
  result = vec4(paint.rgb * paint.a, paint.a);
}`;

/** The ground: a disc that fades out, with a grid and the shadow. */
const GROUND = `${VERSION}
layout(location = 0) in vec2 corner;
uniform mat4 matrix;
uniform vec3 middle;
uniform vec3 across;
uniform vec3 along;
uniform float size;
out vec2 at;
void main() {
  at = corner * size;
  gl_Position = matrix * vec4(middle + at.x * across + at.y * along, 1.0);
}`;

const GROUND_PAINT = `${VERSION}
in vec2 at;
uniform vec2 origin;
uniform float size;
uniform float cell;
uniform vec2 reach;
uniform vec4 paint;
uniform float darkness;
uniform sampler2D shadow;
out vec4 result;
float grid(vec2 p, float pixels) {
  vec2 wide = max(fwidth(p), vec2(1e-6));
  vec2 near = abs(fract(p - 0.5) - 0.5) / wide;
  vec2 line = clamp(pixels - near, 0.0, 1.0) * clamp(0.5 / wide - 0.5, 0.0, 1.0);
  return max(line.x, line.y);
}
void main() {
  float fade = smoothstep(1.0, 0.25, length(at) / size);
  vec2 p = (at + origin) / cell;
  float lines = max(0.38 * grid(p, 1.0), 0.8 * grid(p / 5.0, 1.15));
  vec2 uv = 0.5 + 0.5 * at / reach;
  float dark = 0.0;
  if (all(greaterThan(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)))) {
    // Few samples of coarse pictures: a machine without a graphics card draws this too.
    dark = 0.3 * textureLod(shadow, uv, 2.0).r;
    for (int i = 0; i < 4; i++) {
      vec2 aside = 0.011 * (vec2(i & 1, i >> 1) - 0.5);
      dark += 0.175 * textureLod(shadow, uv + aside, 3.0).r;
    }
  }
  float a = lines * paint.a * fade;
  float s = darkness * dark * fade;
  // The shadow below the lines, both premultiplied.
  result = vec4(paint.rgb * a, a) + vec4(0.0, 0.0, 0.0, s) * (1.0 - a);
}`;

export const SOURCES = {
  skin: [SKIN, LIGHT],
  frustum: [FRUSTUM, LIGHT],
  figure: [FIGURE, LIGHT],
  skinShadow: [SKIN, SHADOW],
  frustumShadow: [FRUSTUM, SHADOW],
  figureShadow: [FIGURE, SHADOW],
  line: [LINE, LINE_PAINT],
  ground: [GROUND, GROUND_PAINT],
};

/** A program that sets its uniforms by name. */
export function program(gl, name) {
  const made = gl.createProgram();
  SOURCES[name].forEach((source, i) => {
    const shader = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  });
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) {
    const logs = gl.getAttachedShaders(made).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`${name}: ${gl.getProgramInfoLog(made)} ${logs.join(" ")}`);
  }
  const places = new Map();
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const { name: uniform, type } = gl.getActiveUniform(made, i);
    places.set(uniform, [gl.getUniformLocation(made, uniform), type]);
  }
  return (uniforms) => {
    gl.useProgram(made);
    for (const [key, value] of Object.entries(uniforms)) {
      if (!places.has(key)) continue;
      const [place, type] = places.get(key);
      if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(place, false, value);
      else if (type === gl.FLOAT) gl.uniform1f(place, value);
      else if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, value);
      else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, value);
      else if (type === gl.FLOAT_VEC4) gl.uniform4fv(place, value);
      else gl.uniform1i(place, value);
    }
  };
}
