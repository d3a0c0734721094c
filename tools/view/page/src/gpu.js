// SPDX-License-Identifier: LGPL-2.1-or-later
// Textures that hold numbers, and the shaders. Positions of a body's nodes are one texture: surface, wireframe, points and
// springs read them by the number of the node, so a frame costs one copy however many things are drawn.
import * as THREE from 'three';
import { colourTable } from './colours.js';

const ROW = 1024; // nodes in a row of a texture

/** A texture of single-precision numbers, `parts` for each item. */
export class Numbers {
  /** @param {number} count @param {1 | 3} parts */
  constructor(count, parts) {
    const rows = Math.max(1, Math.ceil(count / ROW));
    this.data = new Float32Array(ROW * parts * rows);
    this.texture = new THREE.DataTexture(this.data, ROW * parts, rows, THREE.RedFormat, THREE.FloatType);
    this.texture.needsUpdate = true;
  }

  /** @param {ArrayLike<number>} values */
  set(values) {
    this.data.set(values);
    this.texture.needsUpdate = true;
  }

  dispose() {
    this.texture.dispose();
  }
}

/** What all materials share; changed in place. */
export const shared = {
  plane: { value: new THREE.Vector4(1, 0, 0, 0) }, // points with plane.xyz . x > plane.w are cut away
  cut: { value: false },
  exaggeration: { value: 1 },
  map: { value: /** @type {THREE.DataTexture | null} */ (null) },
  range: { value: new THREE.Vector2(0, 1) },
  pixelRatio: { value: 1 },
};

/** @param {string} name of a colour map */
export function setColourMap(name) {
  shared.map.value?.dispose();
  const texture = new THREE.DataTexture(colourTable(name, 256), 256, 1);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  shared.map.value = texture;
}

const HEAD = `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
`;

const NODES = `
uniform sampler2D positions;
uniform sampler2D rest;
uniform float exaggeration;
vec3 row(sampler2D numbers, int i) {
  ivec2 p = ivec2((i % ${ROW}) * 3, i / ${ROW});
  return vec3(texelFetch(numbers, p, 0).r, texelFetch(numbers, p + ivec2(1, 0), 0).r, texelFetch(numbers, p + ivec2(2, 0), 0).r);
}
float number(sampler2D numbers, int i) { return texelFetch(numbers, ivec2(i % ${ROW}, i / ${ROW}), 0).r; }
vec3 drawnAt(int i) {
  vec3 x = row(positions, i);
  if (exaggeration == 1.0) return x;
  vec3 r = row(rest, i);
  return r + exaggeration * (x - r);
}
`;

const CUT = `
uniform vec4 plane;
uniform bool cut;
`;

// The normal of the flat face comes from the derivatives of the place: no normals are computed or sent.
const LIGHT = `
vec3 lit(vec3 colour, vec3 normal, float ambient) {
  float key = max(0.0, dot(normal, normalize(vec3(-0.35, 0.55, 0.75))));
  float fill = max(0.0, dot(normal, normalize(vec3(0.7, -0.2, 0.5))));
  // A square and its root stand for the curve of a screen.
  return sqrt(colour * colour * (ambient + (1.06 - ambient) * (0.82 * key + 0.28 * fill)));
}
`;

const VALUE = `
uniform sampler2D map;
uniform vec2 range;
vec3 mapped(float value) {
  float t = range.y > range.x ? (value - range.x) / (range.y - range.x) : 0.5;
  return texture(map, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
}
`;

const SURFACE_VERTEX = `${HEAD}${NODES}
uniform sampler2D nodeValues;
uniform sampler2D cellValues;
uniform int mode; // 0 colour, 1 values at nodes, 2 values of cells, 3 displacement
in int node;
out vec3 place;
out vec3 eye;
out float value;
void main() {
  place = drawnAt(node);
  value = 0.0;
  if (mode == 1) value = number(nodeValues, node);
  else if (mode == 2) value = number(cellValues, gl_VertexID / 3);
  else if (mode == 3) value = length(row(positions, node) - row(rest, node));
  vec4 view = modelViewMatrix * vec4(place, 1.0);
  eye = view.xyz;
  gl_Position = projectionMatrix * view;
}`;

const SURFACE_FRAGMENT = `${HEAD}${CUT}${LIGHT}${VALUE}
uniform int mode;
uniform vec3 colour;
uniform float opacity;
in vec3 place;
in vec3 eye;
in float value;
out vec4 drawn;
void main() {
  vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
  if (cut && dot(plane.xyz, place) > plane.w) discard;
  vec3 base = mode == 0 ? colour : mapped(value);
  vec3 shaded = lit(base, normal, mode == 0 ? 0.22 : 0.42);
  if (!gl_FrontFacing) shaded *= 0.62;
  drawn = vec4(shaded, opacity);
}`;

// In front of the surface that its node is on.
const LIFTED = `
uniform float lift;
in int node;
out vec3 place;
void lifted() {
  place = drawnAt(node);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place, 1.0);
  gl_Position.z -= lift * gl_Position.w;
}`;

const LINE_VERTEX = `${HEAD}${NODES}${LIFTED}
void main() { lifted(); }`;

const LINE_FRAGMENT = `${HEAD}${CUT}
uniform vec3 colour;
uniform float opacity;
in vec3 place;
out vec4 drawn;
void main() {
  if (cut && dot(plane.xyz, place) > plane.w) discard;
  drawn = vec4(colour, opacity);
}`;

const POINT_VERTEX = `${HEAD}${NODES}${LIFTED}
uniform float size;
uniform float pixelRatio;
void main() {
  lifted();
  gl_PointSize = size * pixelRatio;
}`;

const POINT_FRAGMENT = `${HEAD}${CUT}
uniform vec3 colour;
uniform int shape; // 0 disc, 1 square, 2 diamond
in vec3 place;
out vec4 drawn;
void main() {
  if (cut && dot(plane.xyz, place) > plane.w) discard;
  vec2 p = abs(2.0 * gl_PointCoord - 1.0);
  float edge = shape == 0 ? length(p) : shape == 1 ? max(p.x, p.y) : p.x + p.y;
  if (edge > 1.0) discard;
  drawn = vec4(edge > 0.66 ? vec3(0.08) : colour, 1.0);
}`;

// Triangles and lines whose places the page computes: sections, links, frames.
const PLAIN_VERTEX = `${HEAD}
uniform float lift;
in vec3 position;
in float value;
in vec3 tint;
out float amount;
out vec3 hue;
void main() {
  amount = value;
  hue = tint;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= lift * gl_Position.w;
}`;

const PLAIN_FRAGMENT = `${HEAD}${VALUE}
uniform int mode; // 0 colour, 1 value, 2 tint
uniform vec3 colour;
uniform float opacity;
in float amount;
in vec3 hue;
out vec4 drawn;
void main() { drawn = vec4(mode == 1 ? mapped(amount) : mode == 2 ? hue : colour, opacity); }`;

// Solid arrows and balls: one shape drawn many times.
const SOLID_VERTEX = `${HEAD}
in vec3 position;
in vec3 normal;
in vec4 origin; // w: radius
in vec4 along; // w: 1 for arrows, 2 for rods, 0 for balls
out vec3 eyeNormal;
void main() {
  vec3 place = origin.xyz + position * origin.w;
  vec3 n = normal;
  if (along.w > 0.5) {
    float total = max(length(along.xyz), 1e-20);
    vec3 w = along.xyz / total;
    vec3 u = normalize(abs(w.y) < 0.9 ? cross(w, vec3(0.0, 1.0, 0.0)) : cross(w, vec3(1.0, 0.0, 0.0)));
    vec3 v = cross(w, u);
    float head = along.w > 1.5 ? 0.0 : min(origin.w * 6.0, 0.5 * total);
    float height = position.y <= 1.0 ? position.y * (total - head) : total - head + (position.y - 1.0) * head;
    place = origin.xyz + origin.w * (position.x * u + position.z * v) + height * w;
    n = normal.x * u + normal.y * w + normal.z * v;
  }
  eyeNormal = mat3(modelViewMatrix) * n;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place, 1.0);
}`;

const SOLID_FRAGMENT = `${HEAD}${LIGHT}
uniform vec3 colour;
uniform float opacity;
in vec3 eyeNormal;
out vec4 drawn;
void main() { drawn = vec4(lit(colour, normalize(eyeNormal), 0.4), opacity); }`;

const SHADERS = {
  surface: [SURFACE_VERTEX, SURFACE_FRAGMENT],
  line: [LINE_VERTEX, LINE_FRAGMENT],
  point: [POINT_VERTEX, POINT_FRAGMENT],
  plain: [PLAIN_VERTEX, PLAIN_FRAGMENT],
  solid: [SOLID_VERTEX, SOLID_FRAGMENT],
};

/**
 * @param {keyof typeof SHADERS} kind
 * @param {Record<string, any>} uniforms values of the material's own uniforms
 * @param {object} [options] of three.js
 */
export function material(kind, uniforms, options = {}) {
  const own = Object.fromEntries(Object.entries(uniforms).map(([name, value]) => [name, { value }]));
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: SHADERS[kind][0], fragmentShader: SHADERS[kind][1],
    uniforms: { lift: { value: 0 }, opacity: { value: 1 }, ...own, ...shared }, side: THREE.DoubleSide, ...options,
  });
}

/** Triangles that share their nodes: a sixth of the work of the vertex shader, but no values per triangle. @param {Int32Array} triangles @param {number} nodes */
export function sharedGeometry(triangles, nodes) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('node', new THREE.BufferAttribute(Int32Array.from({ length: nodes }, (_, n) => n), 1));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(triangles.buffer, triangles.byteOffset, triangles.length), 1));
  return geometry;
}

/** A geometry that names nodes only. @param {Int32Array} nodes */
export function nodeGeometry(nodes) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('node', new THREE.BufferAttribute(nodes, 1));
  geometry.setDrawRange(0, nodes.length);
  return geometry;
}
