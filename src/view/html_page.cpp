// SPDX-License-Identifier: BSD-3-Clause
// A small WebGL viewer: layers of points and lines, an orbiting camera, a switch per layer. No
// library, no network.
#include "drawing.h"

namespace xview {
extern const char* const kHtmlPageBegin;
extern const char* const kHtmlPageEnd;

const char* const kHtmlPageBegin = R"page(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>xview</title>
<style>
html, body { margin: 0; height: 100%; background: #fbfbfa; color: #222; font: 14px/1.4 system-ui, sans-serif; }
#viewer { position: relative; height: 100%; overflow: hidden; }
#viewer:not(.alone) { height: 70%; border-bottom: 1px solid #ddd; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; cursor: grab; touch-action: none; }
canvas:active { cursor: grabbing; }
h1 { position: absolute; left: 16px; right: 260px; top: 12px; margin: 0; font-size: 17px; font-weight: 600; pointer-events: none; }
aside { position: absolute; right: 0; top: 0; max-height: 100%; width: 236px; box-sizing: border-box; overflow: auto;
        padding: 12px 14px; background: #ffffffe8; border-left: 1px solid #ddd; }
aside label { display: block; white-space: nowrap; overflow: hidden; text-overflow: ellipsis; }
aside h2 { font-size: 12px; font-weight: 600; color: #777; margin: 12px 0 4px; text-transform: uppercase; letter-spacing: .05em; }
aside h2:first-child { margin-top: 0; }
i { display: inline-block; width: 12px; height: 12px; margin: 0 7px -1px 2px; border: 1px solid #0003; border-radius: 2px; }
input[type=range] { width: 100%; }
button { font: inherit; padding: 2px 10px; margin-right: 4px; }
main { max-width: 1100px; margin: 1.5em auto; padding: 0 1em; }
main pre { background: #f4f4f4; padding: 1em; overflow: auto; }
main table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
main td, main th { padding: .15em .7em; text-align: right; border-bottom: 1px solid #ddd; }
main td:first-child, main th:first-child { text-align: left; }
main figure { display: inline-block; margin: 0 1em 1em 0; }
.accepted { color: #16793a; } .ambiguous { color: #a06800; } .rejected { color: #b3261e; }
#hint { position: absolute; left: 16px; bottom: 10px; color: #777; pointer-events: none; }
</style>
</head>
<body>
<div id="viewer" class="alone">
<canvas id="view"></canvas>
<h1 id="title"></h1>
<aside>
<h2>Layers</h2><div id="layers"></div>
<div id="lifting"><h2>Lift of the queries</h2><input id="lift" type="range" min="0" max="100" step="0.5" value="0"></div>
<h2>View</h2><button id="top">from above</button><button id="side">oblique</button>
<div id="legend"><h2>Classes</h2></div>
</aside>
<div id="hint">drag: turn &middot; shift-drag or right button: move &middot; wheel: zoom</div>
</div>
<script id="scene" type="application/json">)page";

const char* const kHtmlPageEnd = R"page(<script>
'use strict';
const scene = JSON.parse(document.getElementById('scene').textContent);
const byId = id => document.getElementById(id);
const canvas = byId('view');
const gl = canvas.getContext('webgl', {antialias: true});
byId('viewer').classList.toggle('alone', !document.querySelector('main'));
byId('title').textContent = scene.title;
if (scene.title) document.title = scene.title;
if (!gl) byId('hint').textContent = 'This browser has no WebGL: the 3-D view cannot be drawn.';

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

// ---- shaders
const vertexSource = `
attribute vec3 position; attribute vec3 color; attribute float lifted;
uniform mat4 camera; uniform float lift, size, perMetre;
varying vec3 shade;
void main() {
  gl_Position = camera * vec4(position + vec3(0.0, 0.0, lift * lifted), 1.0);
  gl_PointSize = clamp(size * perMetre / gl_Position.w, 1.5, 60.0);
  shade = color;
}`;
const fragmentSource = `
precision mediump float;
varying vec3 shade; uniform float ball;
void main() {
  float light = 1.0;
  if (ball > 0.5) {
    vec2 p = 2.0 * gl_PointCoord - 1.0;
    float r = dot(p, p);
    if (r > 1.0) discard;
    light = 0.55 + 0.45 * sqrt(1.0 - r);
  }
  gl_FragColor = vec4(shade * light, 1.0);
}`;
let program, uniforms = {};
function compile(kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  return shader;
}
function prepare() {
  program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, vertexSource));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, fragmentSource));
  ['position', 'color', 'lifted'].forEach((name, i) => gl.bindAttribLocation(program, i, name));
  gl.linkProgram(program);
  gl.useProgram(program);
  for (const name of ['camera', 'lift', 'size', 'perMetre', 'ball']) uniforms[name] = gl.getUniformLocation(program, name);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0.984, 0.984, 0.98, 1);
}
function buffer(data) {
  const b = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, b);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  return b;
}
function upload(layer) {
  const lifted = new Uint8Array(layer.count);
  if (layer.lift === 'all') lifted.fill(1);
  if (layer.lift === 'starts') for (let i = 0; i < layer.count; i += 2) lifted[i] = 1;
  layer.buffers = [buffer(new Float32Array(bytesOf(layer.positions).buffer)), buffer(bytesOf(layer.colors)), buffer(lifted)];
  layer.positions = layer.colors = null;
}

// ---- camera: an eye that looks at a target
const radius = Math.max(1, scene.radius);
const eye = {target: [0, 0, 0], yaw: -1.9, pitch: 0.75, distance: 2.1 * radius};
function cameraMatrix() {
  const cp = Math.cos(eye.pitch), sp = Math.sin(eye.pitch), cy = Math.cos(eye.yaw), sy = Math.sin(eye.yaw);
  const back = [cp * cy, cp * sy, sp], right = [-sy, cy, 0], up = [-sp * cy, -sp * sy, cp];
  const at = eye.target.map((t, i) => t + eye.distance * back[i]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const near = eye.distance / 100, far = eye.distance + 4 * radius + 1000, f = 1.8;
  const aspect = canvas.width / canvas.height, c = (far + near) / (near - far), d = 2 * far * near / (near - far);
  const rows = [[...right, -dot(right, at)].map(v => v * f / aspect), [...up, -dot(up, at)].map(v => v * f),
                [...back.map(v => v * c), -dot(back, at) * c + d], [...back.map(v => -v), dot(back, at)]];
  const m = new Float32Array(16);
  for (let r = 0; r < 4; ++r) for (let k = 0; k < 4; ++k) m[4 * k + r] = rows[r][k];
  return m;
}
let wanted = false;
function redraw() {
  if (gl && !wanted) { wanted = true; requestAnimationFrame(draw); }
}
function draw() {
  wanted = false;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniformMatrix4fv(uniforms.camera, false, cameraMatrix());
  gl.uniform1f(uniforms.lift, +byId('lift').value);
  gl.uniform1f(uniforms.perMetre, 0.9 * canvas.height);
  for (const layer of scene.layers) {
    if (!layer.shown || layer.count === 0) continue;
    [[3, gl.FLOAT, false], [3, gl.UNSIGNED_BYTE, true], [1, gl.UNSIGNED_BYTE, false]].forEach(([n, type, normalized], i) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, layer.buffers[i]);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, n, type, normalized, 0, 0);
    });
    gl.uniform1f(uniforms.size, layer.size);
    gl.uniform1f(uniforms.ball, layer.kind === 'balls' ? 1 : 0);
    gl.drawArrays(layer.kind === 'lines' ? gl.LINES : gl.POINTS, 0, layer.count);
  }
}

// ---- hands
const fingers = new Map();
function turn(dx, dy) {
  eye.yaw -= dx * 0.006;
  eye.pitch = Math.min(1.5707, Math.max(-0.3, eye.pitch + dy * 0.006));
}
function move(dx, dy) {
  const k = eye.distance / (0.9 * canvas.clientHeight), cy = Math.cos(eye.yaw), sy = Math.sin(eye.yaw);
  const slant = Math.max(0.3, Math.sin(eye.pitch));
  eye.target[0] += k * (dx * sy - dy / slant * cy);
  eye.target[1] += k * (-dx * cy - dy / slant * sy);
}
function zoom(factor) { eye.distance = Math.min(20 * radius, Math.max(1, eye.distance * factor)); }
canvas.addEventListener('contextmenu', e => e.preventDefault());
canvas.addEventListener('pointerdown', e => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, e); });
for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, e => fingers.delete(e.pointerId));
canvas.addEventListener('pointermove', e => {
  const before = fingers.get(e.pointerId);
  if (!before) return;
  const dx = e.clientX - before.clientX, dy = e.clientY - before.clientY;
  if (fingers.size === 2) {
    const other = [...fingers.values()].find(f => f.pointerId !== e.pointerId);
    const gap = f => Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY) || 1;
    zoom(gap(before) / gap(e));
    move(dx / 2, dy / 2);
  } else if (e.shiftKey || e.ctrlKey || (e.buttons & 6)) {
    move(dx, dy);
  } else {
    turn(dx, dy);
  }
  fingers.set(e.pointerId, e);
  redraw();
});
canvas.addEventListener('wheel', e => { e.preventDefault(); zoom(Math.exp(e.deltaY * 0.0012)); redraw(); }, {passive: false});
function look(yaw, pitch) { Object.assign(eye, {target: [0, 0, 0], yaw, pitch, distance: 2.1 * radius}); redraw(); }
byId('top').onclick = () => look(-Math.PI / 2, 1.5707);
byId('side').onclick = () => look(-1.9, 0.75);
byId('lift').oninput = redraw;
byId('lift').max = Math.max(20, radius / 2);
window.addEventListener('resize', redraw);

// ---- panel
function row(parent, parts) {
  const label = document.createElement('label');
  label.append(...parts);
  parent.append(label);
}
for (const layer of scene.layers) {
  const box = document.createElement('input');
  box.type = 'checkbox';
  box.checked = layer.shown;
  box.onchange = () => { layer.shown = box.checked; redraw(); };
  row(byId('layers'), [box, ' ' + layer.name + ' (' + (layer.kind === 'lines' ? layer.count / 2 : layer.count) + ')']);
}
for (const entry of scene.classes) {
  const swatch = document.createElement('i');
  swatch.style.background = 'rgb(' + entry.color.join() + ')';
  row(byId('legend'), [swatch, entry.name]);
}
byId('legend').hidden = scene.classes.length === 0;
byId('lifting').hidden = !scene.layers.some(layer => layer.lift !== 'none');
if (gl) {
  prepare();
  scene.layers.forEach(upload);
  redraw();
}
</script>
</body>
</html>
)page";

}  // namespace xview
