// SPDX-License-Identifier: BSD-3-Clause
// The page of a scene: what the JSON beside it holds, drawn by three.js. Texts only ever become text
// nodes, so that no name can be more than a name.
'use strict';
const scene = JSON.parse(document.getElementById('scene').textContent);
const byId = id => document.getElementById(id);
function element(name, parent, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  if (parent) parent.append(made);
  return made;
}
function decode(base64, Type) {
  const text = atob(base64 || ''), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Type(bytes.buffer);
}
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const rgb = c => 'rgb(' + c.join() + ')';
const hex = c => (c[0] << 16) | (c[1] << 8) | c[2];
const statusHex = {accepted: 0x168a3e, ambiguous: 0xd68200, rejected: 0xc82828};
const kQuery = 0x1e60d6;
const dark = matchMedia('(prefers-color-scheme: dark)');

// ---- headline
byId('title').textContent = document.title = scene.title || 'xview';
byId('caption').textContent = scene.caption;
byId('made').textContent = scene.made_by;
for (const [name, value] of scene.facts) {
  const pair = element('div', byId('facts'));
  element('dt', pair, name);
  element('dd', pair, value);
}

// ---- renderer, camera
THREE.Object3D.DefaultUp.set(0, 0, 1);
const canvas = byId('view');
let renderer = null;
try {
  renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
} catch (problem) {
  byId('caption').textContent += ' This browser has no WebGL: the 3-D view cannot be drawn.';
}
const world = new THREE.Scene();
const radius = Math.max(1e-3, scene.radius);
const camera = new THREE.PerspectiveCamera(45, 1, radius / 500, radius * 60);
camera.up.set(0, 0, 1);
const controls = new THREE.MapControls(camera, canvas);
controls.screenSpacePanning = false;
controls.maxPolarAngle = Math.PI * 0.495;
controls.minDistance = radius / 200;
controls.maxDistance = radius * 12;
const fatLines = [], pointMaterials = [], clouds = [];
let wanted = false;
function redraw() {
  if (!wanted && renderer) { wanted = true; requestAnimationFrame(draw); }
}
// Time per frame [ms] that limits the number of points drawn while the view moves; all when it rests.
const kFrame_ms = 60;
let detail = 1, moving = false, settling = 0;
controls.addEventListener('change', () => {
  moving = true;
  clearTimeout(settling);
  settling = setTimeout(() => { moving = false; redraw(); }, 250);
  redraw();
});
function resize() {
  if (!renderer) return;
  const ratio = Math.min(2, devicePixelRatio || 1), w = innerWidth, h = innerHeight;
  renderer.setPixelRatio(ratio);
  renderer.setSize(w, h, false);
  camera.aspect = w / h;
  // What is looked at lies in the middle of what the panel leaves free.
  if (w > 800) camera.setViewOffset(w, h, 170, 0, w, h); else camera.setViewOffset(w, h, 0, h / 4, w, h);
  camera.updateProjectionMatrix();
  for (const line of fatLines) line.material.resolution.set(w, h);
  for (const material of pointMaterials) material.uniforms.perMetre.value = ratio * h / 2 / Math.tan(Math.PI / 8);
  redraw();
}
function draw() {
  wanted = false;
  for (const cloud of clouds) chooseDetail(cloud, moving ? detail : 1);
  const began = performance.now();
  renderer.render(world, camera);
  showScale();
  const gl = renderer.getContext();
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is drawn
  if (moving) detail = Math.min(1, Math.max(0.05, detail * Math.min(1.2, Math.max(0.4, kFrame_ms / (performance.now() - began)))));
  byId('detail').textContent = moving && detail < 0.95 ? `${Math.ceil(100 * detail)} % of the points while moving` : '';
  if (!document.documentElement.dataset.firstDraw) {
    document.documentElement.dataset.firstDraw = String(Math.round(performance.now()))  // since the page was asked for;
  }
}
// How long a piece of the screen is at what is looked at: the longest of 1, 2, 5, 10, ... m that fits.
function showScale() {
  const metresPerPixel = 2 * Math.tan(Math.PI / 8) * camera.position.distanceTo(controls.target) / innerHeight;
  const most = 140 * metresPerPixel, power = 10 ** Math.floor(Math.log10(most));
  const length = power * [5, 2, 1].find(factor => factor * power <= most);
  byId('bar').style.width = length / metresPerPixel + 'px';
  byId('length').textContent = lengthText(length);
}
// Where the pointer meets the level of what is looked at, in the frame of the map.
const ray = new THREE.Raycaster(), level = new THREE.Plane(new THREE.Vector3(0, 0, 1));
canvas.addEventListener('pointermove', e => {
  ray.setFromCamera(new THREE.Vector2(2 * e.clientX / innerWidth - 1, 1 - 2 * e.clientY / innerHeight), camera);
  level.constant = -controls.target.z;
  const met = ray.ray.intersectPlane(level, new THREE.Vector3());
  byId('pointer').textContent = met ? ['x', 'y'].map((axis, k) => axis + ' ' + (met.getComponent(k) + scene.center[k]).toFixed(2)).join(', ') + ' m' : '';
});
// Some of what is shown, to fit the view to: a share of the points of the cloud, else of the vertices.
function outline() {
  const points = [];
  if (scene.cloud) {
    const p = decode(scene.cloud.positions, Uint16Array), most = Math.ceil(4000 / scene.cloud.chunks.length);
    let first = 0;
    for (const [count, x, y, z, size] of scene.cloud.chunks) {
      for (let i = 3 * first; i < 3 * (first + Math.min(count, most)); i += 3)
        points.push(new THREE.Vector3(x + size * p[i] / 65535, y + size * p[i + 1] / 65535, z + size * p[i + 2] / 65535));
      first += count;
    }
  } else if (scene.graph) {
    const p = decode(scene.graph.positions, Float32Array), step = 3 * Math.ceil(p.length / 12000);
    for (let i = 0; i < p.length; i += step) points.push(new THREE.Vector3(p[i], p[i + 1], p[i + 2]));
  }
  if (points.length < 10)
    for (let corner = 0; corner < 8; ++corner)
      points.push(new THREE.Vector3(...scene.half_size.map((half, k) => corner & (1 << k) ? half : -half)));
  return points;
}
// The whole map, as large as it fits between headline, panel and hints, its longer side along that of the window.
function home(above) {
  const is_tall = (innerWidth > 800 ? innerWidth - 340 : 2 * innerWidth) < innerHeight;
  const across = (scene.half_size[0] >= scene.half_size[1]) !== is_tall;
  const from = new THREE.Vector3(...(above ? across ? [0, -1e-3, 1] : [-1e-3, 0, 1] : across ? [-0.25, -0.72, 0.68] : [-0.72, -0.25, 0.68])).normalize();
  const right = new THREE.Vector3(0, 0, 1).cross(from).normalize(), up = from.clone().cross(right);
  const ahead = new THREE.Vector3(up.x, up.y, 0).normalize();
  const v = 0.82 * Math.tan(Math.PI / 8), h = v * Math.max(0.3, innerWidth > 800 ? (innerWidth - 340) / innerHeight : 2 * innerWidth / innerHeight);
  const points = outline(), target = new THREE.Vector3();
  let distance = 0;
  for (let round = 0; round < 6; ++round) {  // the middle on the screen depends on the distance
    const at = points.map(p => p.clone().sub(target)).map(p => [p.dot(right), p.dot(up), p.dot(from)]);
    distance = Math.max(controls.minDistance, ...at.map(p => p[2] + Math.max(Math.abs(p[0]) / h, Math.abs(p[1]) / v)));
    const middle = k => {
      const seen = at.map(p => p[k] / (1 - p[2] / distance));
      return (Math.min(...seen) + Math.max(...seen)) / 2;
    };
    target.addScaledVector(right, middle(0)).addScaledVector(ahead, middle(1) / ahead.dot(up));
  }
  controls.target.copy(target);
  camera.position.copy(from).multiplyScalar(distance).add(target);
  controls.update();
  redraw();
}
let flight = 0;
function flyTo(target, distance, at_once) {
  const from = controls.target.clone(), goal = new THREE.Vector3(...target);
  const offset = camera.position.clone().sub(from), offsetGoal = offset.clone().setLength(distance);
  const start = performance.now(), mine = ++flight;
  const step = now => {
    if (mine !== flight) return;
    const t = at_once ? 1 : Math.min(1, (now - start) / 650), s = t * t * (3 - 2 * t);
    controls.target.lerpVectors(from, goal, s);
    camera.position.copy(controls.target).add(offset.clone().lerp(offsetGoal, s));
    controls.update();
    redraw();
    if (t < 1) requestAnimationFrame(step);
  };
  step(start);
}

// ---- classes: one palette for all clouds and graphs; a hidden class has no opacity
const palette = new Uint8Array(256 * 4);
const paletteTexture = new THREE.DataTexture(palette, 256, 1, THREE.RGBAFormat);
const hidden = new Set();
function fillPalette() {
  const own = byId('own').checked;
  scene.classes.forEach((c, i) => {
    const shown = own ? c.color : c.quiet.map(v => Math.round(dark.matches ? 30 + 0.6 * v : 0.9 * v));
    palette.set([...shown, hidden.has(i) ? 0 : 255], 4 * i);
    if (c.item) {
      c.item.firstChild.style.background = rgb(shown);
      c.item.classList.toggle('off', hidden.has(i));
    }
  });
  paletteTexture.needsUpdate = true;
  if (renderer) renderer.setClearColor(new THREE.Color(css('--paper')), 1);
  redraw();
}
scene.classes.forEach((c, i) => {
  c.item = element('li', byId('classes').querySelector('ul'));
  element('i', c.item);
  element('span', c.item, c.name);
  element('small', c.item, c.vertices ? c.vertices + ' vertices' : '');
  c.item.onclick = () => { if (!hidden.delete(i)) hidden.add(i); fillPalette(); };
  c.item.ondblclick = () => {  // this class alone, or all again
    const alone = hidden.size === scene.classes.length - 1 && !hidden.has(i);
    hidden.clear();
    if (!alone) scene.classes.forEach((_, k) => k !== i && hidden.add(k));
    fillPalette();
  };
});
byId('classes').hidden = scene.classes.length === 0;
byId('own').onchange = fillPalette;

// ---- points and vertices
function pointMaterial(size, ball, tint, mix) {
  const material = new THREE.ShaderMaterial({
    uniforms: {palette: {value: paletteTexture}, size: {value: size}, least: {value: ball ? 5 : 1.6}, perMetre: {value: 500},
               tint: {value: new THREE.Color(tint || 0)}, mixed: {value: mix || 0}, ball: {value: ball ? 1 : 0}},
    vertexShader: `attribute float kind; uniform sampler2D palette; uniform float size, perMetre, mixed, least; uniform vec3 tint;
      varying vec3 shade;
      void main() {
        vec4 color = texture2D(palette, vec2((kind + 0.5) / 256.0, 0.5));
        vec4 p = modelViewMatrix * vec4(position, 1.0);
        gl_Position = color.a < 0.5 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * p;
        gl_PointSize = clamp(size * perMetre / -p.z, least, 40.0);
        shade = mix(color.rgb, tint, mixed);
      }`,
    fragmentShader: `varying vec3 shade; uniform float ball;
      void main() {
        float light = 1.0;
        if (ball > 0.5) {
          vec2 p = 2.0 * gl_PointCoord - 1.0;
          float r = dot(p, p);
          if (r > 1.0) discard;
          light = r > 0.72 ? 0.35 : 1.0;
        }
        gl_FragColor = vec4(shade * light, 1.0);
      }`});
  pointMaterials.push(material);
  return material;
}
// Chunks of points, each in an order of which every beginning is a fair sample.
function addCloud(parent, data, material) {
  const positions = decode(data.positions, Uint16Array), kinds = decode(data.kinds, Uint8Array);
  let first = 0;
  for (const [count, x, y, z, size] of data.chunks) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions.subarray(3 * first, 3 * (first + count)), 3, true));
    geometry.setAttribute('kind', new THREE.BufferAttribute(kinds.subarray(first, first + count), 1));
    geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(0.5, 0.5, 0.5), 0.87);
    const points = new THREE.Points(geometry, material);
    points.position.set(x, y, z);
    points.scale.setScalar(size);
    points.userData = {count, size};
    parent.add(points);
    clouds.push(points);
    first += count;
  }
}
// More points than pixels only cost time.
const centre = new THREE.Vector3();
function chooseDetail(points, share) {
  const {count, size} = points.userData;
  points.getWorldPosition(centre).addScalar(size / 2);
  const distance = Math.max(1e-6, camera.position.distanceTo(centre) - size);
  const pixels = size * points.material.uniforms.perMetre.value / distance;
  points.geometry.setDrawRange(0, Math.ceil(share * Math.min(count, Math.max(count / 50, 1.5 * pixels * pixels))));
}
const pickable = [];
function addVertices(parent, graph, what, size, tint, mix) {
  const positions = decode(graph.positions, Float32Array), kinds = decode(graph.kinds, Uint8Array);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('kind', new THREE.BufferAttribute(kinds, 1));
  const points = new THREE.Points(geometry, pointMaterial(size, true, tint, mix));
  points.frustumCulled = false;
  parent.add(points);
  pickable.push({parent: points, positions, kinds, of_map: !mix, tell: i => {
    const told = [what + ': ' + scene.classes[kinds[i]].name, place(positions, i)];
    const seen = graph.observations[i];
    told.push('seen in ' + seen + (seen === 1 ? ' frame' : ' frames') + (graph.points[i] ? ', ' + graph.points[i] + ' points' : ''));
    if (graph.sigmas[i] > 0) told.push('sigma ' + lengthText(graph.sigmas[i]));
    return told.join('\n');
  }});
}
const place = (p, i, digits = 2) => ['x', 'y', 'z'].map((axis, k) => axis + ' ' + (p[3 * i + k] + scene.center[k]).toFixed(digits)).join(', ') + ' m';
function show(lines) {
  byId('picked').hidden = false;
  byId('picked').textContent = lines.join('\n');
}
const lengthText = m => m < 0.01 ? (1000 * m).toFixed(0) + ' mm' : m < 1 ? (100 * m).toFixed(0) + ' cm' : m.toFixed(m < 10 ? 1 : 0) + ' m';

// ---- lines: pairs of ends
function addLines(parent, ends, color, width, dashed) {
  if (ends.length === 0) return null;
  const geometry = new THREE.LineSegmentsGeometry();
  geometry.setPositions(ends);
  const material = new THREE.LineMaterial({color, linewidth: width, dashed: !!dashed, dashSize: radius / 100, gapSize: radius / 150});
  if (dashed) material.defines.USE_DASH = '';
  const lines = new THREE.LineSegments2(geometry, material);
  if (dashed) lines.computeLineDistances();
  lines.frustumCulled = false;
  parent.add(lines);
  fatLines.push(lines);
  return lines;
}
function arrow(parent, pose, heading, color, size, hollow) {
  const shape = new THREE.BufferGeometry(), h = new THREE.Vector3(...heading);
  const side = h.clone().cross(new THREE.Vector3(0, 0, 1));
  if (side.length() < 0.2) side.set(1, 0, 0);
  side.normalize();
  const lift = new THREE.Vector3(0, 0, size * 0.15), at = (a, s) =>
    new THREE.Vector3(...pose).add(lift).addScaledVector(h, a * size).addScaledVector(side, s * size).toArray();
  shape.setAttribute('position', new THREE.BufferAttribute(new Float32Array([...at(1, 0), ...at(-0.8, 0.7), ...at(-0.4, 0),
    ...at(1, 0), ...at(-0.4, 0), ...at(-0.8, -0.7)]), 3));
  parent.add(new THREE.Mesh(shape, new THREE.MeshBasicMaterial({color, side: THREE.DoubleSide, depthTest: false, transparent: true,
    opacity: hollow ? 0.6 : 1})));
}

// A number that keeps its size on the screen.
function numberAt(parent, number, at, color) {
  const image = document.createElement('canvas'), pen = image.getContext('2d');
  image.width = image.height = 64;
  Object.assign(pen, {font: 'bold 44px sans-serif', textAlign: 'center', textBaseline: 'middle', lineWidth: 9, strokeStyle: css('--paper'), fillStyle: color});
  pen.strokeText(number, 32, 34);
  pen.fillText(number, 32, 34);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(image), sizeAttenuation: false, depthTest: false, transparent: true}));
  sprite.scale.setScalar(0.04);
  sprite.position.set(...at);
  parent.add(sprite);
}

// ---- layers: what has one switch, also what comes later
function addLayer(name, count, color, objects, shown) {
  const layer = {shown, objects: []};
  layer.add = object => { object.visible = layer.shown; layer.objects.push(object); };
  const item = element('li', byId('layers').querySelector('ul'));
  element('i', item).style.background = color;
  element('span', item, name);
  element('small', item, count);
  item.onclick = () => {
    layer.shown = !layer.shown;
    for (const object of layer.objects) object.visible = layer.shown;
    item.classList.toggle('off', !layer.shown);
    redraw();
  };
  item.classList.toggle('off', !shown);
  for (const object of objects) { layer.add(object); world.add(object); }
  return layer;
}
const group = () => new THREE.Group();
let layer;
if (scene.cloud) {
  addCloud(layer = group(), scene.cloud, pointMaterial(scene.cloud.size, false));
  const thinned = scene.cloud.shown < scene.cloud.total ? ' of ' + scene.cloud.total : '';
  addLayer(scene.cloud.name, scene.cloud.shown + thinned + ' points', '#999', [layer], true);
}
if (scene.graph) {
  addVertices(layer = group(), scene.graph, 'map vertex', scene.vertex_size);
  addLayer('map vertices', scene.graph.observations.length, '#555', [layer], !scene.cloud);
  const edges = decode(scene.graph.edges, Float32Array);
  const drawn = edges.length / 6, short = drawn < scene.graph.edges_in_all ? ', the shortest of ' + scene.graph.edges_in_all : '';
  if (addLines(layer = group(), edges, 0x9aa0aa, 1)) addLayer('map edges', drawn + short, '#9aa0aa', [layer], !scene.cloud);
}
for (const line of scene.lines) {
  const ends = decode(line.ends, Float32Array);
  if (addLines(layer = group(), ends, hex(line.color), 2)) addLayer(line.name, '', rgb(line.color), [layer], true);
}
function addMarks(marks, in_front) {
  const positions = decode(marks.positions, Float32Array);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  const material = new THREE.PointsMaterial({color: hex(marks.color), size: in_front ? 9 : 7, sizeAttenuation: false, depthTest: !in_front, transparent: in_front});
  material.onBeforeCompile = shader => {  // a little nearer than what they speak of, which would hide them
    shader.vertexShader = shader.vertexShader.replace('#include <project_vertex>',
      '#include <project_vertex>\ngl_Position = projectionMatrix * vec4(0.98 * mvPosition.xyz, 1.0);');
  };
  const dots = new THREE.Points(geometry, material);
  dots.frustumCulled = false;
  pickable.push({parent: dots, positions, tell: i => [marks.group, marks.notes[i], place(positions, i)].filter(Boolean).join('\n')});
  return {dots, positions};
}
const listedMarks = [], kMostListed = 300;
for (const marks of scene.marks) {
  const {dots, positions} = addMarks(marks, true);
  addLayer(marks.group, marks.notes.length, rgb(marks.color), [dots], true);
  if (!marks.listed) continue;
  marks.notes.slice(0, kMostListed - listedMarks.length).forEach((note, i) => {
    const item = element('li', byId('marks').querySelector('ol'));
    item.style.setProperty('--status', rgb(marks.color));
    element('span', item, place(positions, i, 1));
    element('b', item, marks.group + ' ');
    element('div', item, note, 'name');
    item.onclick = () => {
      flyTo(positions.slice(3 * i, 3 * i + 3), radius / 6);
      show([marks.group, note, place(positions, i)]);
    };
    listedMarks.push({item, text: marks.group + ' ' + note});
  });
}
const marksInAll = scene.marks.reduce((sum, marks) => sum + marks.notes.length, 0);
if (marksInAll > listedMarks.length) element('p', byId('marks'), (marksInAll - listedMarks.length) + (listedMarks.length ? ' more are in the picture' : ' are in the picture only'));
byId('marks').hidden = marksInAll === 0;

// ---- queries
const poses = group(), ways = group(), queryLayers = new Map();
const arrowSize = radius / 60;
let chosen = null;
function lifted(q) {  // the part of a query that is raised, and its correspondences
  const lift = q === chosen && q.kept.length ? +byId('lift').value : 0;
  if (q.raised) q.raised.position.z = lift;
  for (const [lines, ends] of q.matches) {
    const moved = ends.slice();
    for (let i = 2; i < moved.length; i += 6) moved[i] += lift;
    lines.geometry.setPositions(moved);
  }
  redraw();
}
function build(q) {  // what is only shown of the chosen query
  q.group = group();
  q.raised = group();
  q.group.add(q.raised);
  const shared = (name, color, object, parent, shown = true) => {
    if (!queryLayers.has(name)) queryLayers.set(name, addLayer(name, '', color, [], shown));
    queryLayers.get(name).add(object);
    parent.add(object);
  };
  // Marks lie on what they speak of, which would hide them.
  const points = group(), things = group(), isMarked = q.marks.length > 0;
  if (q.cloud) {
    addCloud(points, q.cloud, pointMaterial(q.cloud.size, false, kQuery, 0.8));
    shared('points of the query', rgb([30, 96, 214]), points, q.raised, !isMarked);
  }
  if (q.graph) {
    addVertices(things, q.graph, 'query vertex', scene.vertex_size, kQuery, 0.35);
    shared('vertices of the query', rgb([30, 96, 214]), things, q.raised, !isMarked);
  }
  for (const [name, ends, color, width] of [['matches, left out', q.putative, 0xd69696, 1], ['matches, kept', q.kept, 0x14a03c, 2.5]]) {
    const parent = group(), lines = addLines(parent, ends, color, width);
    if (!lines) continue;
    q.matches.push([lines, ends]);
    shared(name, '#' + color.toString(16).padStart(6, '0'), parent, q.group, !isMarked);
  }
  for (const marks of q.marks) shared(marks.group, rgb(marks.color), addMarks(marks, false).dots, q.group);
  const radiusOfPlace = 3 * arrowSize;
  const others = group();
  if (q.hypotheses.length > 1) shared('other places', rgb([214, 130, 0]), others, q.group);
  q.hypotheses.slice(1).forEach((h, i) => {
    const ring = new THREE.Mesh(new THREE.RingBufferGeometry(0.8 * radiusOfPlace, radiusOfPlace, 40),
                                new THREE.MeshBasicMaterial({color: statusHex.ambiguous, side: THREE.DoubleSide, depthTest: false, transparent: true}));
    ring.position.set(...h);
    others.add(ring);
    numberAt(others, i + 2, h, css('--ambiguous'));
  });
  world.add(q.group);
  resize();
}
function choose(q, at_once) {
  if (chosen) { chosen.item.classList.remove('chosen'); if (chosen.group) chosen.group.visible = false; }
  chosen = q;
  q.item.classList.add('chosen');
  if (!q.pose) return redraw();
  if (!q.group) build(q);
  q.group.visible = true;
  byId('lifting').hidden = q.matches.length === 0;
  byId('lift').max = Math.max(10 * arrowSize, q.extent);
  byId('lift').value = q.matches.length && !q.marks.length ? q.extent / 5 : 0;
  lifted(q);
  flyTo([q.middle[0], q.middle[1], q.pose[2]], Math.max(8 * arrowSize, 1.4 * q.extent), at_once);
}
scene.queries.forEach(q => {
  q.kept = decode(q.kept, Float32Array);
  q.putative = decode(q.putative, Float32Array);
  q.matches = [];
  q.item = element('li', byId('queries').querySelector('ol'), undefined, q.status);
  const right = [q.error !== null ? lengthText(q.error) + ' off' : q.sigma !== null && q.status === 'accepted' ? '±' + lengthText(q.sigma) : ''];
  element('span', q.item, right.join(' '));
  element('b', q.item, q.status + ' ');
  element('div', q.item, q.name + (q.elsewhere ? ' (from elsewhere)' : ''), 'name');
  const numbers = [];
  if (q.chance_wrong) numbers.push('wrong ' + q.chance_wrong);
  if (q.sigma !== null && q.status === 'accepted') numbers.push('sigma ' + lengthText(q.sigma));
  if (q.error !== null) numbers.push('error ' + lengthText(q.error) + (q.error_deg !== null ? ', ' + q.error_deg.toFixed(2) + '°' : ''));
  if (q.ms !== null) numbers.push((q.ms / 1000).toFixed(2) + ' s');
  element('p', q.item, q.reason);
  element('p', q.item, numbers.join(' · '));
  if (q.hypotheses.length > 1) {
    const others = element('p', q.item, 'other places: ');
    q.hypotheses.slice(1).forEach((h, i) => {
      element('button', others, String(i + 2)).onclick = event => { event.stopPropagation(); flyTo(h, 20 * arrowSize); };
    });
  }
  q.item.onclick = () => choose(q);
  if (!q.pose) return;
  addLines(ways, decode(q.way, Float32Array), statusHex[q.status], 3);
  addLines(ways, decode(q.truth, Float32Array), dark.matches ? 0xffffff : 0x141414, 2, true);
  arrow(poses, q.pose, q.heading, statusHex[q.status], arrowSize);
  if (q.error_line) addLines(ways, q.error_line, statusHex[q.status], 2);
});
const posed = scene.queries.filter(q => q.pose);
if (posed.length) {
  addLayer('ways of queries', '', rgb([22, 138, 62]), [ways], true);
  addLayer('poses of queries', posed.length, rgb([22, 138, 62]), [poses], true);
  pickable.push({parent: poses, positions: new Float32Array(posed.flatMap(q => q.pose)),
                 tell: i => { choose(posed[i]); return posed[i].status + ': ' + posed[i].name + '\n' + posed[i].reason; }});
}
byId('queries').hidden = scene.queries.length === 0;
byId('lifting').hidden = true;
byId('lift').oninput = () => chosen && lifted(chosen);

// ---- charts: the SVG files that stand beside the page
for (const svg of scene.charts)
  byId('charts').append(document.importNode(new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement, true));
byId('charts').hidden = scene.charts.length === 0;

// ---- picking: what is nearest to the pointer on the screen
function isShown(object) {
  for (let o = object; o; o = o.parent) if (!o.visible) return false;
  return true;
}
const spot = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({color: 0xe0218a, size: 9, sizeAttenuation: false, depthTest: false, transparent: true}));
spot.frustumCulled = spot.visible = false;
world.add(spot);
function markSpot(p) {
  spot.visible = !!p;
  if (p) spot.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(p.toArray()), 3));
  redraw();
}
// The foremost of the points that are drawn around the pointer, with what is known of the vertex it belongs to.
function pickPoint(x, y) {
  const toScreen = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const matrix = new THREE.Matrix4(), p = new THREE.Vector3();
  let best = null, foremost = 1;
  for (const points of clouds) {
    if (!isShown(points)) continue;
    matrix.multiplyMatrices(toScreen, points.matrixWorld);
    const at = points.geometry.attributes.position.array, kinds = points.geometry.attributes.kind.array;
    for (let i = 0; i < Math.min(points.geometry.drawRange.count, kinds.length); ++i) {
      p.set(at[3 * i], at[3 * i + 1], at[3 * i + 2]).multiplyScalar(1 / 65535).applyMatrix4(matrix);
      if (p.z >= foremost || hidden.has(kinds[i])) continue;
      if (Math.hypot((p.x + 1) / 2 * innerWidth - x, (1 - p.y) / 2 * innerHeight - y) > 5) continue;
      foremost = p.z;
      best = {kind: kinds[i], of_query: points.material.uniforms.mixed.value > 0,
              at: new THREE.Vector3(at[3 * i], at[3 * i + 1], at[3 * i + 2]).multiplyScalar(1 / 65535).applyMatrix4(points.matrixWorld)};
    }
  }
  if (!best) return null;
  const told = [(best.of_query ? 'query point: ' : 'map point: ') + scene.classes[best.kind].name, place(best.at.toArray(), 0)];
  const graph = pickable.find(set => set.of_map);
  let nearest = -1, distance = 20 * scene.vertex_size;
  for (let i = 0; graph && !best.of_query && i < graph.kinds.length; ++i) {
    if (graph.kinds[i] !== best.kind) continue;
    const d = p.fromArray(graph.positions, 3 * i).distanceTo(best.at);
    if (d < distance) { distance = d; nearest = i; }
  }
  if (nearest >= 0) told.push('nearest vertex of its class, ' + lengthText(distance) + ' away:', ...graph.tell(nearest).split('\n').slice(1));
  return {told, at: best.at};
}
function pick(x, y) {
  let best = null, nearest = 12 * 12;
  const p = new THREE.Vector3();
  for (const set of pickable) {
    if (!isShown(set.parent)) continue;
    set.parent.updateWorldMatrix(true, false);
    for (let i = 0; i < set.positions.length / 3; ++i) {
      if (set.kinds && hidden.has(set.kinds[i])) continue;
      p.set(set.positions[3 * i], set.positions[3 * i + 1], set.positions[3 * i + 2]).applyMatrix4(set.parent.matrixWorld).project(camera);
      if (p.z > 1) continue;
      const dx = (p.x + 1) / 2 * innerWidth - x, dy = (1 - p.y) / 2 * innerHeight - y;
      if (dx * dx + dy * dy < nearest) { nearest = dx * dx + dy * dy; best = [set, i]; }
    }
  }
  byId('picked').hidden = true;
  const point = best ? null : pickPoint(x, y);
  if (best) show([best[0].tell(best[1])]);
  if (point) show(point.told);
  markSpot(point ? point.at : best && p.fromArray(best[0].positions, 3 * best[1]).applyMatrix4(best[0].parent.matrixWorld));
}
let pressed = null;
canvas.addEventListener('pointerdown', e => { pressed = [e.clientX, e.clientY]; ++flight; });
canvas.addEventListener('pointerup', e => {
  if (pressed && Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) < 4) pick(e.clientX, e.clientY);
});

// ---- search, views
byId('search').oninput = () => {
  const wantedText = byId('search').value.toLowerCase();
  for (const q of scene.queries) q.item.hidden = !(q.name + ' ' + q.status + ' ' + q.reason).toLowerCase().includes(wantedText);
  for (const mark of listedMarks) mark.item.hidden = !mark.text.toLowerCase().includes(wantedText);
  for (const c of scene.classes) c.item.hidden = !c.name.toLowerCase().includes(wantedText);
};
byId('search').onkeydown = e => {
  const found = e.key === 'Enter' && [...scene.queries, ...listedMarks].find(entry => !entry.item.hidden);
  if (found) found.item.click();
};
byId('top').onclick = () => home(true);
byId('side').onclick = () => home(false);
addEventListener('resize', resize);
dark.addListener(fillPalette);
if (renderer) {
  fillPalette();
  home(false);
  resize();
  if (scene.queries.length === 1) choose(scene.queries[0], true);
  // page.html#query=3 opens with the third query.
  const asked = /query=(\d+)/.exec(location.hash);
  if (asked && scene.queries[asked[1] - 1]) choose(scene.queries[asked[1] - 1], true);
  draw();
  if (/pick/.test(location.hash)) pick((innerWidth > 800 ? innerWidth - 340 : innerWidth) / 2, innerHeight / 2);
  document.documentElement.dataset.ready = 'yes';
}
