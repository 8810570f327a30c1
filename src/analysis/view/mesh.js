// Drawing of a mesh of triangles, quadrilaterals and lines, mirrored about the axis and coloured by a field: by WebGL 2, or
// on a plain canvas without it. Corners, positions and values are textures, so a frame is two uploads and one draw call.
const NO_CORNER = 0xffffffff;
// Texels in a row of a texture. Every implementation of WebGL 2 has 2048.
const ROW = 2048;
// Number that stands for "no value", because shaders need not distinguish NaN.
const NO_VALUE = 3e38;

const VERTEX = `#version 300 es
precision highp float; precision highp int;
uniform highp usampler2D corners; uniform highp usampler2D hidden; uniform highp sampler2D positions; uniform highp sampler2D values;
uniform bool onCells; uniform bool hasValues; uniform bool hasHidden; uniform int selected;
uniform vec3 toX; uniform vec3 toY; uniform vec2 size; uniform float thickness;
out float value; out vec2 uv; flat out int kind; flat out int marked;
ivec2 at(int i) { return ivec2(i % ${ROW}, i / ${ROW}); }
vec2 pixel(uint point) {
  vec2 p = texelFetch(positions, at(int(point)), 0).rg;
  vec3 q = vec3(gl_InstanceID == 0 ? p.x : -p.x, p.y, 1.0);
  return vec2(dot(toX, q), dot(toY, q));
}
void main() {
  int cell = gl_VertexID / 4, k = gl_VertexID % 4;
  uvec4 all = texelFetch(corners, at(cell), 0);
  kind = all.z == ${NO_CORNER}u ? 2 : all.w == ${NO_CORNER}u ? 1 : 0;
  marked = cell == selected ? 1 : 0;
  uv = vec2(k == 1 || k == 2 ? 1.0 : 0.0, k > 1 ? 1.0 : 0.0);
  if (all.x == ${NO_CORNER}u || hasHidden && texelFetch(hidden, at(cell), 0).r != 0u) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  uint point; vec2 p;
  if (kind == 2) {
    vec2 a = pixel(all.x), b = pixel(all.y), along = b - a;
    vec2 across = vec2(-along.y, along.x) / max(length(along), 1e-6) * thickness * (k < 2 ? 0.5 : -0.5);
    point = k == 0 || k == 3 ? all.x : all.y;
    p = (k == 0 || k == 3 ? a : b) + across;
  } else {
    point = k == 0 ? all.x : k == 1 ? all.y : k == 2 || kind == 1 ? all.z : all.w;
    if (kind == 1 && k == 3) uv = vec2(1.0, 1.0);
    p = pixel(point);
  }
  value = hasValues ? texelFetch(values, at(onCells ? cell : int(point)), 0).r : ${NO_VALUE.toExponential()};
  gl_Position = vec4(2.0 * p.x / size.x - 1.0, 1.0 - 2.0 * p.y / size.y, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float; precision highp int;
in float value; in vec2 uv; flat in int kind; flat in int marked;
uniform sampler2D colours; uniform vec2 range; uniform vec3 plain; uniform vec3 line; uniform bool edges; uniform bool hasValues;
out vec4 colour;
float near(float distance) { return 1.0 - smoothstep(0.2, 1.0, distance / max(fwidth(distance), 1e-9)); }
void main() {
  bool none = value > 1e38;
  float part = range.y > range.x ? clamp((value - range.x) / (range.y - range.x), 0.0, 1.0) : 0.0;
  vec3 paint = none ? (kind == 2 ? line : plain) : texture(colours, vec2((part * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (kind != 2 && (edges || marked == 1)) {
    float edge = kind == 1 ? max(max(near(uv.y), near(1.0 - uv.x)), near(uv.x - uv.y))
      : max(max(near(uv.x), near(1.0 - uv.x)), max(near(uv.y), near(1.0 - uv.y)));
    paint = mix(paint, line, edge * (marked == 1 ? 1.0 : 0.5));
  }
  if (marked == 1) paint = mix(paint, vec3(1.0, 0.2, 0.1), 0.65);
  colour = vec4(paint, 1.0);
}`;

const rgb = text => {
  const hex = text.replace('#', '');
  return [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);
};
const rowsOf = count => Math.max(1, Math.ceil(count / ROW));

/** Creates the drawing on a canvas: `setMesh`, `setShape`, `setValues`, then `draw`. */
function meshDrawing(canvas) {
  const g = canvas.getContext('webgl2', { antialias: true, alpha: true, preserveDrawingBuffer: true });
  return g ? drawingByWebgl(canvas, g) : drawingOnCanvas(canvas);
}

function drawingByWebgl(canvas, g) {
  const last = { mesh: null, shape: null, values: null };
  let program, at, textures, cells = 0;
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
    textures = [];
    program = g.createProgram();
    for (const [kind, text] of [[g.VERTEX_SHADER, VERTEX], [g.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = g.createShader(kind);
      g.shaderSource(shader, text); g.compileShader(shader);
      if (!g.getShaderParameter(shader, g.COMPILE_STATUS) && !g.isContextLost()) throw new Error(g.getShaderInfoLog(shader));
      g.attachShader(program, shader);
    }
    g.linkProgram(program);
    if (!g.getProgramParameter(program, g.LINK_STATUS) && !g.isContextLost()) throw new Error(g.getProgramInfoLog(program));
    g.useProgram(program);
    at = new Proxy({}, { get: (known, name) => known[name] ??= g.getUniformLocation(program, name) });
    ['corners', 'positions', 'values', 'hidden', 'colours'].forEach((name, unit) => g.uniform1i(at[name], unit));
    g.pixelStorei(g.UNPACK_ALIGNMENT, 1);
    const map = Uint8Array.from({ length: 1024 }, (_, i) => i % 4 === 3 ? 255 : Number(COLOURS[i >> 2].match(/\d+/g)[i % 4]));
    texture(4, g.RGBA8, g.RGBA, g.UNSIGNED_BYTE, 256, map, 256);
    texture(2, g.R32F, g.RED, g.FLOAT, 1, new Float32Array(1));
    texture(3, g.R8UI, g.RED_INTEGER, g.UNSIGNED_BYTE, 1, new Uint8Array(1));
  };
  const drawing = {
    kind: 'WebGL 2',
    setMesh(mesh) {
      last.mesh = mesh; last.shape = null; last.values = null;
      cells = mesh.cells;
      texture(0, g.RGBA32UI, g.RGBA_INTEGER, g.UNSIGNED_INT, cells, mesh.corners);
      const order = [0, 1, 2, 0, 2, 3], indices = new Uint32Array(6 * cells);
      for (let c = 0; c < cells; c++) for (let k = 0; k < 6; k++) indices[6 * c + k] = 4 * c + order[k];
      g.bindBuffer(g.ELEMENT_ARRAY_BUFFER, g.createBuffer());
      g.bufferData(g.ELEMENT_ARRAY_BUFFER, indices, g.STATIC_DRAW);
    },
    setShape(shape) {
      if (last.shape === shape) return;
      last.shape = shape;
      texture(1, g.RG32F, g.RG, g.FLOAT, shape.positions.length / 2, shape.positions);
      if (shape.hidden.length) texture(3, g.R8UI, g.RED_INTEGER, g.UNSIGNED_BYTE, shape.hidden.length, shape.hidden);
    },
    setValues(values, onCells) {
      if (last.values === values) return;
      last.values = values; last.onCells = onCells;
      if (values) texture(2, g.R32F, g.RED, g.FLOAT, values.length, values);
    },
    draw({ width, height, toX, toY, range, plain, line, edges, selected }) {
      if (g.isContextLost()) return;
      if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
      g.viewport(0, 0, width, height);
      g.clearColor(0, 0, 0, 0); g.clear(g.COLOR_BUFFER_BIT);
      if (!last.shape) return;
      g.uniform3fv(at.toX, toX); g.uniform3fv(at.toY, toY); g.uniform2f(at.size, width, height); g.uniform2fv(at.range, range);
      g.uniform3fv(at.plain, rgb(plain)); g.uniform3fv(at.line, rgb(line));
      g.uniform1i(at.edges, edges); g.uniform1i(at.selected, selected); g.uniform1i(at.hasValues, !!last.values);
      g.uniform1i(at.onCells, !!last.onCells); g.uniform1i(at.hasHidden, last.shape.hidden.length > 0);
      g.uniform1f(at.thickness, (last.values ? 5 : 2) * (devicePixelRatio || 1));
      g.drawElementsInstanced(g.TRIANGLES, 6 * cells, g.UNSIGNED_INT, 0, 2);
    },
    finish: () => g.finish(),
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

/** The same drawing without WebGL, slower. */
function drawingOnCanvas(canvas) {
  const g = canvas.getContext('2d'), last = {};
  return {
    kind: 'canvas',
    setMesh(mesh) { last.mesh = mesh; last.shape = null; last.values = null; },
    setShape(shape) { last.shape = shape; },
    setValues(values, onCells) { last.values = values; last.onCells = onCells; },
    draw({ width, height, toX, toY, range, plain, line, edges, selected }) {
      canvas.width = width; canvas.height = height;
      const { mesh, shape, values, onCells } = last;
      if (!shape) return;
      for (let c = 0; c < mesh.cells; c++) {
        const list = cornersOf(mesh, c);
        if (!list.length || shape.hidden[c]) continue;
        const value = values ? onCells ? values[c] : list.reduce((sum, p) => sum + values[p], 0) / list.length : NO_VALUE;
        const part = range[1] > range[0] ? Math.min(1, Math.max(0, (value - range[0]) / (range[1] - range[0]))) : 0;
        const paint = c === selected ? '#ff3319' : value > 1e38 ? list.length === 2 ? line : plain : COLOURS[Math.round(255 * part)];
        for (const side of [1, -1]) {
          g.beginPath();
          list.forEach((p, i) => {
            const r = side * shape.positions[2 * p], z = shape.positions[2 * p + 1];
            g[i ? 'lineTo' : 'moveTo'](toX[0] * r + toX[1] * z + toX[2], toY[0] * r + toY[1] * z + toY[2]);
          });
          g.strokeStyle = edges && list.length > 2 ? line : paint; g.fillStyle = paint;
          g.lineWidth = list.length === 2 ? values ? 5 : 2 : 0.7;
          if (list.length > 2) { g.closePath(); g.fill(); }
          g.stroke();
        }
      }
    },
    finish: () => g.getImageData(0, 0, 1, 1),
  };
}

const cornersOf = (mesh, cell) => [0, 1, 2, 3].map(i => mesh.corners[4 * cell + i]).filter(p => p !== NO_CORNER);
