// Drawing of a mesh of triangles, quadrilaterals and lines, mirrored about the axis and coloured by a field: by WebGL 2, or
// by the processor. With WebGL, positions and values are textures, so a frame is two uploads and one draw call.
const NO_CORNER = 0xffffffff;
// Texels in a row of a texture. Every implementation of WebGL 2 has 2048.
const ROW = 2048;
// Number that stands for "no value", because shaders need not distinguish NaN.
const NO_VALUE = 3e38;

const VERTEX = `#version 300 es
precision highp float; precision highp int;
in ivec4 vertex; // Point, cell, other point of a line or -1, side of the line.
uniform highp usampler2D hidden; uniform highp sampler2D positions; uniform highp sampler2D values;
uniform bool onCells; uniform bool hasValues; uniform bool hasHidden; uniform int selected;
uniform vec3 toX; uniform vec3 toY; uniform vec2 size; uniform float thickness;
out float value; flat out float ofCell; flat out int kind;
ivec2 at(int i) { return ivec2(i % ${ROW}, i / ${ROW}); }
vec2 pixel(int point) {
  vec2 p = texelFetch(positions, at(point), 0).rg;
  vec3 q = vec3(gl_InstanceID == 0 ? p.x : -p.x, p.y, 1.0);
  return vec2(dot(toX, q), dot(toY, q));
}
void main() {
  int cell = max(vertex.y, 0);
  bool isLine = vertex.z >= 0;
  vec2 p = pixel(vertex.x);
  if (isLine) {
    vec2 along = pixel(vertex.z) - p;
    p += vec2(-along.y, along.x) / max(length(along), 1e-6) * 0.5 * thickness * float(vertex.w);
  }
  value = hasValues ? texelFetch(values, at(onCells ? cell : vertex.x), 0).r : ${NO_VALUE.toExponential()};
  ofCell = value;
  kind = hasHidden && texelFetch(hidden, at(cell), 0).r != 0u ? 3 : cell == selected ? 2 : isLine ? 1 : 0;
  gl_Position = vec4(2.0 * p.x / size.x - 1.0, 1.0 - 2.0 * p.y / size.y, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float; precision highp int;
in float value; flat in float ofCell; flat in int kind;
uniform sampler2D colours; uniform vec2 range; uniform vec3 plain; uniform vec3 line; uniform bool onCells; uniform bool edges;
out vec4 colour;
void main() {
  if (kind == 3 && !edges) discard;
  float shown = onCells ? ofCell : value;
  float part = range.y > range.x ? clamp((shown - range.x) / (range.y - range.x), 0.0, 1.0) : 0.0;
  vec3 paint = shown > 1e38 ? (kind == 1 ? line : plain) : texture(colours, vec2((part * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (kind == 2) paint = vec3(1.0, 0.2, 0.1);
  colour = edges ? vec4(line, 1.0) * 0.5 : vec4(paint, 1.0);
}`;

/** Returns vertices and triangles. Cells share the vertices of their points. The last vertex of a triangle says which cell it
 * belongs to, so each cell has one vertex for itself: a corner that no other cell has taken, or else a copy. */
function trianglesOf(mesh) {
  const { cells, points } = mesh, indices = [], owner = new Int32Array(points).fill(-1), copies = [];
  const copy = (...vertex) => { copies.push(...vertex); return points + copies.length / 4 - 1; };
  for (let c = 0; c < cells; c++) {
    const list = cornersOf(mesh, c), n = list.length;
    if (n === 2) {
      // A rectangle: the direction from the second point to the first one is opposite, and so are its sides.
      const [a, b, d, e] = [[0, 1, 1], [0, 1, -1], [1, 0, 1], [1, 0, -1]].map(([p, q, side]) => copy(list[p], c, list[q], side));
      indices.push(a, b, d, a, d, e);
      continue;
    }
    if (n < 3) continue;
    const free = list.findIndex(p => owner[p] < 0), own = Math.max(0, free);
    const last = free < 0 ? copy(list[own], c, -1, 0) : list[own];
    if (free >= 0) owner[list[own]] = c;
    for (let k = 1; k < n - 1; k++) indices.push(list[(own + k) % n], list[(own + k + 1) % n], last);
  }
  const vertices = new Int32Array(4 * points + copies.length);
  for (let p = 0; p < points; p++) vertices.set([p, owner[p], -1, 0], 4 * p);
  vertices.set(copies, 4 * points);
  return { vertices, indices: Uint32Array.from(indices) };
}

/** Returns the edges of the visible elements as pairs of points. */
function edgesOf(mesh, hidden) {
  const pairs = [];
  for (let c = 0; c < mesh.cells; c++) {
    const list = hidden[c] ? [] : cornersOf(mesh, c);
    if (list.length > 2) list.forEach((p, i) => pairs.push(p, list[(i + 1) % list.length]));
  }
  return Uint32Array.from(pairs);
}

const rgb = text => {
  const hex = text.replace('#', '');
  return [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);
};
const rowsOf = count => Math.max(1, Math.ceil(count / ROW));

/** Creates the drawing on a canvas: `setMesh`, `setShape`, `setValues`, then `draw`. WebGL is used if a graphics processor
 * supports it, or in any case with `#webgl` in the address. */
function meshDrawing(canvas) {
  // A canvas has one kind of context for ever, so the graphics processor is asked for by another canvas.
  const isFast = () => {
    const probe = document.createElement('canvas').getContext('webgl2', { failIfMajorPerformanceCaveat: true });
    const names = probe && probe.getExtension('WEBGL_debug_renderer_info');
    const name = probe ? probe.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : probe.RENDERER) : 'none';
    probe?.getExtension('WEBGL_lose_context')?.loseContext();
    return probe && !/swiftshader|llvmpipe|software|basic render/i.test(name);
  };
  const g = location.hash === '#webgl' || isFast() ? canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true }) : null;
  return g ? drawingByWebgl(canvas, g) : drawingByProcessor(canvas);
}

function drawingByWebgl(canvas, g) {
  const last = { mesh: null, shape: null, values: null };
  let program, at, textures, buffers, count = 0, edges = null;
  const texture = (unit, inside, format, type, count, data, width = ROW) => {
    const rows = rowsOf(count);
    g.activeTexture(g.TEXTURE0 + unit);
    const old = textures[unit];
    if (!old || old.count !== count) {
      if (old) g.deleteTexture(old.texture);
      textures[unit] = { texture: g.createTexture(), count };
      g.bindTexture(g.TEXTURE_2D, textures[unit].texture);
      for (const key of [g.TEXTURE_MIN_FILTER, g.TEXTURE_MAG_FILTER]) g.texParameteri(g.TEXTURE_2D, key, g.NEAREST);
      for (const key of [g.TEXTURE_WRAP_S, g.TEXTURE_WRAP_T]) g.texParameteri(g.TEXTURE_2D, key, g.CLAMP_TO_EDGE);
      g.texStorage2D(g.TEXTURE_2D, 1, inside, width, rows);
    } else g.bindTexture(g.TEXTURE_2D, old.texture);
    // Whole rows, then the rest of the last one: the data need not be copied to a full rectangle.
    const parts = data.length / count, whole = width === ROW ? Math.floor(count / ROW) : rows, rest = count - whole * ROW;
    if (whole) g.texSubImage2D(g.TEXTURE_2D, 0, 0, 0, width, whole, format, type, data);
    if (width === ROW && rest > 0) g.texSubImage2D(g.TEXTURE_2D, 0, 0, whole, rest, 1, format, type, data.subarray(whole * ROW * parts));
  };
  const begin = () => {
    textures = []; buffers = [0, 1, 2].map(() => g.createBuffer()); edges = null;
    program = g.createProgram();
    for (const [kind, text] of [[g.VERTEX_SHADER, VERTEX], [g.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = g.createShader(kind);
      g.shaderSource(shader, text); g.compileShader(shader);
      if (!g.getShaderParameter(shader, g.COMPILE_STATUS) && !g.isContextLost()) throw new Error(g.getShaderInfoLog(shader));
      g.attachShader(program, shader);
    }
    g.bindAttribLocation(program, 0, 'vertex');
    g.linkProgram(program);
    if (!g.getProgramParameter(program, g.LINK_STATUS) && !g.isContextLost()) throw new Error(g.getProgramInfoLog(program));
    g.useProgram(program);
    at = new Proxy({}, { get: (known, name) => known[name] ??= g.getUniformLocation(program, name) });
    ['positions', 'values', 'hidden', 'colours'].forEach((name, unit) => g.uniform1i(at[name], unit));
    g.pixelStorei(g.UNPACK_ALIGNMENT, 1);
    const map = Uint8Array.from({ length: 1024 }, (_, i) => i % 4 === 3 ? 255 : Number(COLOURS[i >> 2].match(/\d+/g)[i % 4]));
    texture(3, g.RGBA8, g.RGBA, g.UNSIGNED_BYTE, 256, map, 256);
    texture(1, g.R32F, g.RED, g.FLOAT, 1, new Float32Array(1));
    texture(2, g.R8UI, g.RED_INTEGER, g.UNSIGNED_BYTE, 1, new Uint8Array(1));
  };
  const drawEdges = () => {
    g.bindBuffer(g.ELEMENT_ARRAY_BUFFER, buffers[2]);
    if (!edges || edges.hidden !== last.shape.hidden && (edges.hidden.length || last.shape.hidden.length)) {
      const pairs = edgesOf(last.mesh, last.shape.hidden);
      g.bufferData(g.ELEMENT_ARRAY_BUFFER, pairs, g.DYNAMIC_DRAW);
      edges = { hidden: last.shape.hidden, count: pairs.length };
    }
    g.uniform1i(at.edges, true);
    g.enable(g.BLEND); g.blendFunc(g.ONE, g.ONE_MINUS_SRC_ALPHA);
    g.drawElementsInstanced(g.LINES, edges.count, g.UNSIGNED_INT, 0, 2);
    g.disable(g.BLEND);
  };
  const drawing = {
    kind: 'WebGL 2',
    setMesh(mesh) {
      last.mesh = mesh; last.shape = null; last.values = null;
      edges = null;
      const { vertices, indices } = mesh.triangles ??= trianglesOf(mesh);
      count = indices.length;
      g.bindBuffer(g.ARRAY_BUFFER, buffers[0]);
      g.bufferData(g.ARRAY_BUFFER, vertices, g.STATIC_DRAW);
      g.enableVertexAttribArray(0);
      g.vertexAttribIPointer(0, 4, g.INT, 0, 0);
      g.bindBuffer(g.ELEMENT_ARRAY_BUFFER, buffers[1]);
      g.bufferData(g.ELEMENT_ARRAY_BUFFER, indices, g.STATIC_DRAW);
    },
    setShape(shape) {
      if (last.shape === shape) return;
      last.shape = shape;
      texture(0, g.RG32F, g.RG, g.FLOAT, shape.positions.length / 2, shape.positions);
      if (shape.hidden.length) texture(2, g.R8UI, g.RED_INTEGER, g.UNSIGNED_BYTE, shape.hidden.length, shape.hidden);
    },
    setValues(values, onCells) {
      if (last.values === values) return;
      last.values = values; last.onCells = onCells;
      if (values) texture(1, g.R32F, g.RED, g.FLOAT, values.length, values);
    },
    draw({ width, height, toX, toY, range, plain, line, edges: withEdges, selected }) {
      if (g.isContextLost()) return;
      if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
      g.viewport(0, 0, width, height);
      g.clearColor(0, 0, 0, 0); g.clear(g.COLOR_BUFFER_BIT);
      if (!last.shape) return;
      g.uniform3fv(at.toX, toX); g.uniform3fv(at.toY, toY); g.uniform2f(at.size, width, height); g.uniform2fv(at.range, range);
      g.uniform3fv(at.plain, rgb(plain)); g.uniform3fv(at.line, rgb(line));
      g.uniform1i(at.edges, false); g.uniform1i(at.selected, selected); g.uniform1i(at.hasValues, !!last.values);
      g.uniform1i(at.onCells, !!last.onCells); g.uniform1i(at.hasHidden, last.shape.hidden.length > 0);
      g.uniform1f(at.thickness, (last.values ? 5 : 2) * (devicePixelRatio || 1));
      g.bindBuffer(g.ELEMENT_ARRAY_BUFFER, buffers[1]);
      g.drawElementsInstanced(g.TRIANGLES, count, g.UNSIGNED_INT, 0, 2);
      if (withEdges) drawEdges();
    },
    // Reading a pixel waits until everything is drawn.
    finish: () => g.readPixels(0, 0, 1, 1, g.RGBA, g.UNSIGNED_BYTE, new Uint8Array(4)),
  };
  canvas.addEventListener('webglcontextlost', e => e.preventDefault());
  canvas.addEventListener('webglcontextrestored', () => {
    const { mesh, shape, values, onCells } = last;
    begin();
    if (mesh) drawing.setMesh(mesh);
    if (shape) drawing.setShape(shape);
    drawing.setValues(values, onCells);
    canvas.dispatchEvent(new Event('redraw'));
  });
  begin();
  return drawing;
}

/** The same drawing by the processor, for computers without a graphics processor: polygons are filled row by row. A
 * rasteriser for few large triangles, as in software versions of WebGL, is many times slower for small elements. */
function drawingByProcessor(canvas) {
  const g = canvas.getContext('2d'), last = {};
  let image = null, pixels = null, width = 0, height = 0, x = new Float32Array(0), y = x;
  // A pixel as one number: red is the lowest byte.
  const packed = ([r, g_, b]) => (255 << 24 | b << 16 | g_ << 8 | r) >>> 0;
  const map = Uint32Array.from(COLOURS, text => packed(text.match(/\d+/g).map(Number)));
  const ofHex = text => packed(rgb(text).map(v => Math.round(255 * v)));
  /** Fills the pixels whose centres are in a convex polygon with the corners a, b, c, d. */
  const fill = (a, b, c, d, paint) => {
    const ya = y[a], yb = y[b], yc = y[c], yd = y[d];
    const top = Math.max(0, Math.ceil(Math.min(ya, yb, yc, yd) - 0.5)), bottom = Math.min(height - 1, Math.ceil(Math.max(ya, yb, yc, yd) - 0.5) - 1);
    for (let row = top; row <= bottom; row++) {
      const at = row + 0.5;
      let low = 1e9, high = -1e9, v;
      if ((ya <= at) !== (yb <= at)) { v = x[a] + (at - ya) * (x[b] - x[a]) / (yb - ya); if (v < low) low = v; if (v > high) high = v; }
      if ((yb <= at) !== (yc <= at)) { v = x[b] + (at - yb) * (x[c] - x[b]) / (yc - yb); if (v < low) low = v; if (v > high) high = v; }
      if ((yc <= at) !== (yd <= at)) { v = x[c] + (at - yc) * (x[d] - x[c]) / (yd - yc); if (v < low) low = v; if (v > high) high = v; }
      if ((yd <= at) !== (ya <= at)) { v = x[d] + (at - yd) * (x[a] - x[d]) / (ya - yd); if (v < low) low = v; if (v > high) high = v; }
      const from = Math.max(0, Math.ceil(low - 0.5)), to = Math.min(width, Math.ceil(high - 0.5)), start = row * width;
      for (let i = from; i < to; i++) pixels[start + i] = paint;
    }
  };
  /** Draws a line of some pixels in width. */
  const stroke = (a, b, paint, thickness) => {
    const [dx, dy] = [x[b] - x[a], y[b] - y[a]], steps = Math.ceil(Math.max(Math.abs(dx), Math.abs(dy)));
    if (!(steps < 20000)) return;
    const before = Math.floor(thickness / 2);
    for (let k = 0; k <= steps; k++) {
      const px = Math.floor(x[a] + dx * k / (steps || 1)) - before, py = Math.floor(y[a] + dy * k / (steps || 1)) - before;
      for (let j = Math.max(0, py); j < Math.min(height, py + thickness); j++) for (let i = Math.max(0, px); i < Math.min(width, px + thickness); i++) pixels[j * width + i] = paint;
    }
  };
  const project = (positions, side, toX, toY) => {
    const count = positions.length / 2;
    if (x.length !== count) { x = new Float32Array(count); y = new Float32Array(count); }
    for (let p = 0; p < count; p++) {
      const r = side * positions[2 * p], z = positions[2 * p + 1];
      x[p] = toX[0] * r + toX[1] * z + toX[2]; y[p] = toY[0] * r + toY[1] * z + toY[2];
    }
  };
  const drawSide = ({ range, plain, line, edges, selected }) => {
    const { mesh: { cells, corners }, shape: { hidden }, values, onCells } = last, [low, high] = range, scale = high > low ? 255 / (high - low) : 0;
    const [noValue, dark, red] = [ofHex(plain), ofHex(line), packed([255, 51, 25])], thick = Math.round((values ? 5 : 2) * (devicePixelRatio || 1));
    for (let c = 0; c < cells; c++) {
      const a = corners[4 * c], b = corners[4 * c + 1], d = corners[4 * c + 2], e = corners[4 * c + 3];
      if (a === NO_CORNER || hidden.length && hidden[c]) continue;
      const isLine = d === NO_CORNER, isTriangle = e === NO_CORNER;
      let value = NO_VALUE;
      if (values) value = onCells ? values[c] : isLine ? (values[a] + values[b]) / 2 : isTriangle ? (values[a] + values[b] + values[d]) / 3 : (values[a] + values[b] + values[d] + values[e]) / 4;
      const paint = c === selected ? red : value > 1e37 ? isLine ? dark : noValue : map[Math.round(Math.min(255, Math.max(0, (value - low) * scale)))];
      if (isLine) stroke(a, b, paint, thick);
      else fill(a, b, d, isTriangle ? d : e, paint);
    }
    if (!edges) return;
    for (let c = 0; c < cells; c++) {
      const list = hidden.length && hidden[c] ? [] : cornersOf(last.mesh, c);
      if (list.length > 2) list.forEach((p, i) => stroke(p, list[(i + 1) % list.length], dark, 1));
    }
  };
  return {
    kind: 'processor',
    setMesh(mesh) { last.mesh = mesh; last.shape = null; last.values = null; },
    setShape(shape) { last.shape = shape; },
    setValues(values, onCells) { last.values = values; last.onCells = onCells; },
    draw(look) {
      if (!image || width !== look.width || height !== look.height) {
        [width, height] = [canvas.width, canvas.height] = [look.width, look.height];
        image = g.createImageData(width, height);
        pixels = new Uint32Array(image.data.buffer);
      }
      pixels.fill(0);
      if (last.shape) for (const side of [-1, 1]) {
        project(last.shape.positions, side, look.toX, look.toY);
        drawSide(look);
      }
      g.putImageData(image, 0, 0);
    },
    finish: () => g.getImageData(0, 0, 1, 1),
  };
}

const cornersOf = (mesh, cell) => [0, 1, 2, 3].map(i => mesh.corners[4 * cell + i]).filter(p => p !== NO_CORNER);
