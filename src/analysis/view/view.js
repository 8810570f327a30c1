// The live view of a job: events of the server (view/watch.rs) say what has changed, frames are fetched when they are shown.
const data = JSON.parse(document.getElementById('data').textContent);
// Bytes of frames that the page keeps; the time of reading a frame times PAUSE passes before the next one of a running job.
const MEMORY = 512 * 1048576, PAUSE = 50;
const MARGIN = { left: 58, right: 14, top: 10, bottom: 40 };
const parts = { setup: null, frames: { generation: 0, times: [], fields: [], units: ['', ''] }, status: {}, progress: null, run: null, warnings: [], faults: [], changed: [] };

// ---- frames ----
/** Frames of the server, kept by number, their meshes, and the range of each field in the frames that have been loaded. `mesh` is
 * that of the frame that is shown. */
const store = {
  mesh: null, meshes: new Map(), kept: new Map(), bytes: 0, ranges: [], bounds: null, wanted: new Map(), reading: 0,
  reset() { this.mesh = null; this.meshes.clear(); this.kept.clear(); this.bytes = 0; this.ranges = []; this.bounds = null; this.wanted.clear(); },
  async fetchBytes(address) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error((await answer.text()).trim());
    const timing = /dur=([\d.]+)/.exec(answer.headers.get('Server-Timing') || '');
    if (timing) this.reading = Number(timing[1]);
    return answer.arrayBuffer();
  },
  /** Returns a mesh; its number is that of a frame that has it. */
  loadMesh(number) {
    if (!this.meshes.has(number)) this.meshes.set(number, this.readMesh(number).catch(error => { this.meshes.delete(number); throw error; }));
    return this.meshes.get(number);
  },
  async readMesh(number) {
    const bytes = await this.fetchBytes(`mesh?frame=${number}`), [points, cells] = new Uint32Array(bytes, 0, 2), at = 8 + 16 * cells;
    const mesh = { number, points, cells, corners: new Uint32Array(bytes, 8, 4 * cells), elements: new Int32Array(bytes, at, cells), materials: new Int32Array(bytes, at + 4 * cells, cells) };
    mesh.chains = outlines(mesh, mesh.corners, NO_CORNER);
    this.bytes += bytes.byteLength;
    return mesh;
  },
  /** Returns the frame if it is there, with the values of a field unless `field` is -1. */
  get(frame, field) {
    const found = this.kept.get(frame);
    return found && (field < 0 || found.values.has(field)) ? found : null;
  },
  load(frame, field) {
    const found = this.get(frame, field), key = `${frame}/${field}`;
    if (found) return Promise.resolve(found);
    if (!this.wanted.has(key)) this.wanted.set(key, this.read(frame, field).finally(() => this.wanted.delete(key)));
    return this.wanted.get(key);
  },
  async read(frame, field) {
    const { generation } = parts.frames, shape = this.kept.has(frame) ? '' : '&shape=1';
    const bytes = await this.fetchBytes(`frame?frame=${frame}${field < 0 ? '' : `&field=${field}`}${shape}`);
    if (generation !== parts.frames.generation) throw new Error('the run has been restarted');
    // Meanwhile another request may have loaded the frame, or it may have been removed.
    if (!this.kept.has(frame) && !shape) return this.read(frame, field);
    const [number, positions, values, hidden] = new Uint32Array(bytes, 0, 4), mesh = shape ? await this.loadMesh(number) : null;
    if (generation !== parts.frames.generation) throw new Error('the run has been restarted');
    const old = this.kept.get(frame);
    const found = old || { mesh, positions: new Float32Array(bytes, 16, positions), hidden: new Uint8Array(bytes, 16 + 4 * (positions + values), hidden), values: new Map() };
    if (field >= 0) found.values.set(field, this.take(new Float32Array(bytes, 16 + 4 * positions, values), field, found.hidden));
    if (!old) this.extend(found.positions);
    this.kept.delete(frame); this.kept.set(frame, found);
    this.bytes += bytes.byteLength;
    for (const [oldest, it] of this.kept) {
      if (this.bytes <= MEMORY || oldest === frame) break;
      this.kept.delete(oldest);
      this.bytes -= it.positions.byteLength + it.hidden.byteLength + [...it.values.values()].reduce((sum, v) => sum + v.byteLength, 0);
      if (it.mesh !== this.mesh && ![...this.kept.values()].some(other => other.mesh === it.mesh)) this.forgetMesh(it.mesh);
    }
    return found;
  },
  forgetMesh(mesh) {
    this.meshes.delete(mesh.number);
    this.bytes -= mesh.corners.byteLength + mesh.elements.byteLength + mesh.materials.byteLength;
  },
  /** Marks numbers that are no values, and extends the range of the field, without deleted elements. */
  take(values, field, hidden) {
    const skips = hidden.length > 0 && parts.frames.fields[field].on_cells;
    let low = Infinity, high = -Infinity;
    for (let i = 0; i < values.length; i++) {
      const v = values[i];
      if (!Number.isFinite(v)) { values[i] = NO_VALUE; continue; }
      if (skips && hidden[i]) continue;
      if (v < low) low = v;
      if (v > high) high = v;
    }
    values.range = [low, high];
    const range = this.ranges[field] ??= [Infinity, -Infinity];
    this.ranges[field] = [Math.min(range[0], low), Math.max(range[1], high)];
    return values;
  },
  extend(positions) {
    let [r, low, high] = this.bounds || [0, Infinity, -Infinity];
    for (let i = 0; i < positions.length; i += 2) {
      r = Math.max(r, Math.abs(positions[i])); low = Math.min(low, positions[i + 1]); high = Math.max(high, positions[i + 1]);
    }
    this.bounds = [r, low, high];
  },
};
/** Returns the cell of a chosen element in a mesh; -1 if the mesh does not have the element. */
function cellIn(mesh, choice) {
  if (!choice || !mesh || mesh === choice.mesh) return choice ? choice.cell : -1;
  const element = choice.mesh.elements[choice.cell];
  return element ? mesh.elements.indexOf(element) : -1;
}

// ---- the mesh ----
/** Deformed mesh with its controls. `onShow` is called when a frame is shown, `onPick` when an element is chosen. */
function meshView(onShow, onPick) {
  const under = make('canvas', {}), canvas = make('canvas', { role: 'img', tabindex: 0, class: 'mesh', 'aria-label': 'Deformed mesh, mirrored about the axis' });
  const stage = make('div', { class: 'stage' }, under, canvas), tip = make('div', { class: 'tip', hidden: '' });
  const slider = make('input', { type: 'range', min: 0, max: 0, value: 0, step: 1, 'aria-label': 'frame' });
  const button = (text, title, act) => { const b = make('button', { type: 'button', title }, text); b.addEventListener('click', act); return b; };
  const clock = make('output', {}), chooser = make('select', { 'aria-label': 'field' });
  const speed = make('select', { 'aria-label': 'frames per second' }, ...[5, 10, 20, 30, 60].map(n => make('option', { value: n }, `${n} per s`)));
  const own = make('input', { type: 'checkbox' }), edges = make('input', { type: 'checkbox' }), follow = make('input', { type: 'checkbox', checked: '' });
  const bar = make('i', { style: { background: `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => COLOURS[Math.round(i * 255 / 8)]).join(',')})` } });
  const name = make('b', {}), marks = make('div', { class: 'marks' }), scale = make('div', { class: 'scale' }, name, make('div', { class: 'colours' }, bar, marks));
  const empty = make('p', { class: 'soft empty' }, 'No frame has been written yet.');
  const drawing = meshDrawing(canvas);
  const state = { frame: 0, field: 0, asked: 0, choice: null, selected: -1, playing: 0, zoom: 1, centre: null, next: 0, later: 0, shown: 0 };
  let fit = null, back = () => [0, 0], pending = false;
  speed.value = 20;
  chooser.append(make('option', { value: -1 }, 'no field'));

  const fieldOf = () => parts.frames.fields[state.field];
  const range = () => {
    const found = store.get(state.frame, state.field);
    if (state.field < 0 || !found) return [0, 1];
    const [low, high] = own.checked ? found.values.get(state.field).range : store.ranges[state.field];
    return low <= high ? [low, high] : [0, 1];
  };
  /** Shows a frame as soon as it is there; a later request replaces an earlier one. */
  const show = async frame => {
    const count = parts.frames.times.length;
    if (!count) return;
    frame = Math.min(count - 1, Math.max(0, frame));
    const ask = ++state.asked, field = state.field;
    slider.value = frame;
    try {
      // The first frame for the bounds of the view.
      if (!store.bounds) await store.load(0, -1);
      const found = store.get(frame, field) || await store.load(frame, field);
      if (ask !== state.asked) return;
      state.frame = frame;
      if (found.mesh !== store.mesh) setMesh(found.mesh);
      drawing.setShape(found);
      // Without values if the frame does not have the field.
      const values = field < 0 ? null : found.values.get(field);
      drawing.setValues(values?.length ? values : null, field >= 0 && parts.frames.fields[field].on_cells);
      draw();
      state.shown++;
      onShow(frame);
      prefetch();
    } catch (error) { if (ask === state.asked) view.fault(error.message); }
  };
  const setMesh = mesh => {
    store.mesh = mesh;
    drawing.setMesh(mesh);
    state.selected = cellIn(mesh, state.choice);
  };
  /** Loads all frames of a finished job, for the range of the colours and for playing; they are at most half of the memory. */
  const prefetch = async () => {
    const { generation, times } = parts.frames, key = `${generation}/${state.field}/${times.length}`;
    if (!view.ended() || state.prefetched === key) return;
    state.prefetched = key;
    for (let frame = 0; frame < times.length && state.prefetched === key && store.bytes < MEMORY / 2; frame++) {
      if (store.get(frame, state.field)) continue;
      try { await store.load(frame, state.field); } catch { return; }
      draw();
    }
  };
  /** Shows the last frame of a running job, not more often than the part of a processor that a view may use allows. */
  const showLast = () => {
    if (!follow.checked || state.playing || state.later) return;
    const wait = Math.max(0, state.next - performance.now());
    state.later = setTimeout(async () => {
      state.reading = store.reading = 0;
      await show(parts.frames.times.length - 1);
      state.next = performance.now() + (view.ended() ? 0 : PAUSE * store.reading);
      state.later = 0;
      if (state.frame < parts.frames.times.length - 1 && follow.checked && !state.playing) showLast();
    }, wait);
  };
  /** Intervals of r and z that are shown: the bodies, and the faces of targets near them. */
  const whole = () => {
    let [r, low, high] = store.bounds;
    const size = Math.max(high - low, 2 * r);
    for (const layer of layersOf(view.scene())) for (const face of [layer.from, layer.to]) {
      if (face > low - 0.25 * size && face < high + 0.25 * size) { low = Math.min(low, face); high = Math.max(high, face); }
    }
    const reach = Math.max(1.25 * r, 0.12 * (high - low));
    return { r: [-reach, reach], z: [low - 0.05 * size, high + 0.05 * size] };
  };
  const draw = () => {
    if (pending) return;
    pending = true;
    requestAnimationFrame(() => { pending = false; paint(); });
  };
  const paint = () => {
    const found = store.get(state.frame, -1);
    if (!found || found.mesh !== store.mesh) return;
    empty.hidden = true;
    const all = whole(), long = all.z[1] - all.z[0] > all.r[1] - all.r[0], ratio = devicePixelRatio || 1;
    const width = stage.clientWidth || 700, spanX = long ? all.z[1] - all.z[0] : all.r[1] - all.r[0], spanY = long ? all.r[1] - all.r[0] : all.z[1] - all.z[0];
    const inner = width - MARGIN.left - MARGIN.right, high = Math.round(Math.min(560, Math.max(240, inner * spanY / spanX)));
    const height = high + MARGIN.top + MARGIN.bottom, unit = Math.min(inner / spanX, high / spanY) * state.zoom;
    const centre = state.centre || [0.5 * (all.r[0] + all.r[1]), 0.5 * (all.z[0] + all.z[1])];
    const [cx, cy] = [MARGIN.left + inner / 2, MARGIN.top + high / 2];
    fit = { unit, long, centre };
    const toX = long ? [0, unit, cx - unit * centre[1]] : [unit, 0, cx - unit * centre[0]];
    const toY = long ? [-unit, 0, cy + unit * centre[0]] : [0, -unit, cy + unit * centre[1]];
    const project = (r, z) => [toX[0] * r + toX[1] * z + toX[2], toY[0] * r + toY[1] * z + toY[2]];
    back = (x, y) => long ? [(toY[2] - y) / unit, (x - toX[2]) / unit] : [(x - toX[2]) / unit, (toY[2] - y) / unit];
    stage.style.height = `${height}px`;
    const [rA, zA] = back(MARGIN.left, MARGIN.top), [rB, zB] = back(width - MARGIN.right, height - MARGIN.bottom);
    const region = { r: [Math.min(rA, rB), Math.max(rA, rB)], z: [Math.min(zA, zB), Math.max(zA, zB)] };
    paintUnder(found, { width, height, ratio, project, region, long, box: [MARGIN.left, MARGIN.top, inner, high] });
    const box = { left: MARGIN.left, top: MARGIN.top, width: inner, height: high };
    for (const key of ['left', 'top', 'width', 'height']) canvas.style[key] = `${box[key]}px`;
    const shift = (line, from) => [line[0] * ratio, line[1] * ratio, (line[2] - from) * ratio];
    // Edges of elements of a few pixels would hide the colours.
    const [reach, low, top] = store.bounds, isCoarse = Math.sqrt(reach * (top - low) / store.mesh.cells) * unit > 4;
    const look = { width: Math.round(inner * ratio), height: Math.round(high * ratio), toX: shift(toX, box.left), toY: shift(toY, box.top) };
    drawing.draw({ ...look, range: range(), plain: ink('--body'), line: ink('--soft'), edges: edges.checked && isCoarse, selected: state.selected });
    label();
  };
  /** Draws what is below the mesh: targets, planes, axis, rigid bodies, ticks. It is skipped while nothing of it changes. */
  let painted = '';
  const paintUnder = (found, at) => {
    const key = JSON.stringify([at.width, at.height, at.ratio, at.region, ink('--ground'), view.scene(), found.mesh.chains.length ? state.frame : 0]);
    if (key === painted) return;
    painted = key;
    under.width = Math.round(at.width * at.ratio); under.height = Math.round(at.height * at.ratio);
    const g = under.getContext('2d'), reach = Math.max(...at.region.r.map(Math.abs)), [a, b] = at.region.z;
    g.setTransform(at.ratio, 0, 0, at.ratio, 0, 0);
    g.save();
    g.beginPath(); g.rect(...at.box); g.clip();
    drawLayers(g, layersOf(view.scene()), [a, b, reach], at.project, at.long);
    drawPlanes(g, view.scene(), [a, b, reach], at.project);
    drawAxis(g, [a, b], at.project);
    drawBodies(g, found.mesh.chains, p => [found.positions[2 * p], found.positions[2 * p + 1]], at.project);
    g.restore();
    paintTicks(g, at);
  };
  const paintTicks = (g, { box: [x, y, w, h], long, region, project }) => {
    g.strokeStyle = ink('--line'); g.lineWidth = 1; g.strokeRect(x, y, w, h);
    g.fillStyle = ink('--soft'); g.font = '11.5px system-ui, sans-serif';
    const [across, up] = long ? [region.z, region.r] : [region.r, region.z];
    const xs = ticks(...across, Math.max(3, Math.round(w / 110))), ys = ticks(...up, Math.max(3, Math.round(h / 60)));
    // Radii are positive on both sides; both axes have the same power of ten.
    const size = (v, isRadius) => isRadius ? Math.abs(v) : v;
    const texts = labels([...xs.map(v => size(v, !long)), ...ys.map(v => size(v, long))]);
    g.textAlign = 'center';
    xs.forEach((v, i) => g.fillText(texts.texts[i], long ? project(0, v)[0] : project(v, 0)[0], y + h + 16));
    g.fillText(withUnit(long ? 'z' : 'r', parts.frames.units[0], texts.exponent), x + w / 2, y + h + 34);
    g.fillText(long ? 'r' : 'z', 10, y + h / 2);
    g.textAlign = 'right';
    ys.forEach((v, i) => g.fillText(texts.texts[xs.length + i], x - 6, (long ? project(v, 0)[1] : project(0, v)[1]) + 4));
  };
  let scaled = '';
  const label = () => {
    const { times, units } = parts.frames, field = fieldOf(), [low, high] = range();
    clock.value = `frame ${state.frame + 1} of ${times.length}, time ${show6(times[state.frame])}${units[1] ? ` ${units[1]}` : ''}`;
    scale.hidden = !field;
    const key = JSON.stringify([field, low, high]);
    if (!field || key === scaled) return;
    scaled = key;
    const values = high > low ? [0, 1, 2, 3, 4].map(i => low + (high - low) * i / 4) : [low], written = labels(values);
    name.textContent = withUnit(field.name, field.unit, written.exponent);
    marks.replaceChildren(...written.texts.map(text => make('span', {}, text)));
  };
  const show6 = v => window.show(v, 6);
  const playing = on => {
    if (!!state.playing === on) return;
    state.playing = on ? performance.now() : 0;
    play.textContent = on ? 'pause' : 'play';
    if (on) { follow.checked = false; requestAnimationFrame(advance); }
  };
  /** Shows the next frame when it is due; a frame that is not there is waited for. */
  const advance = async now => {
    if (!state.playing) return;
    if (now - state.playing >= 1000 / Number(speed.value) - 2) {
      state.playing = now;
      const next = (state.frame + 1) % parts.frames.times.length;
      await show(next);
      store.load((next + 1) % parts.frames.times.length, state.field).catch(() => {});
    }
    requestAnimationFrame(advance);
  };
  const step = by => { playing(false); follow.checked = false; show(state.frame + by); };
  const play = button('play', 'play the frames', () => playing(!state.playing));
  const cellAt = (x, y) => {
    const found = store.get(state.frame, -1), { mesh } = store;
    if (!found || found.mesh !== mesh) return -1;
    const [r, z] = back(x + MARGIN.left, y + MARGIN.top), near = 5 / fit.unit;
    const point = (p, side) => [side * found.positions[2 * p], found.positions[2 * p + 1]];
    for (let c = 0; c < mesh.cells; c++) {
      if (found.hidden[c]) continue;
      const list = cornersOf(mesh, c);
      if (!list.length) continue;
      const shape = list.map(p => point(p, r < 0 ? -1 : 1));
      if (shape.length > 2 ? inside(shape, r, z) : distance(shape, r, z) < near) return c;
    }
    return -1;
  };
  const distance = ([[ax, ay], [bx, by]], x, y) => {
    const t = Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2 || 1)));
    return Math.hypot(x - ax - t * (bx - ax), y - ay - t * (by - ay));
  };
  const setField = field => { state.field = field; chooser.value = field; onPick(state.choice); return show(state.frame); };
  /** Chooses the element of a cell of the mesh that is shown; -1 for none. */
  const select = cell => {
    state.choice = cell < 0 ? null : { mesh: store.mesh, cell };
    state.selected = cell;
    draw();
    onPick(state.choice);
  };
  // Dragging moves the view, the wheel changes its scale, a double click shows all. A click without a drag selects.
  let drag = null;
  canvas.addEventListener('pointerdown', e => { if (e.button === 0 && fit) { drag = { x: e.clientX, y: e.clientY, centre: fit.centre, moved: false }; if (e.isTrusted) canvas.setPointerCapture(e.pointerId); } });
  canvas.addEventListener('pointermove', e => {
    if (!drag) { hover(e); return; }
    const [dx, dy] = [e.clientX - drag.x, e.clientY - drag.y];
    if (Math.hypot(dx, dy) > 4) drag.moved = true;
    if (drag.moved) { state.centre = fit.long ? [drag.centre[0] + dy / fit.unit, drag.centre[1] - dx / fit.unit] : [drag.centre[0] - dx / fit.unit, drag.centre[1] + dy / fit.unit]; draw(); }
  });
  canvas.addEventListener('pointerup', e => { if (drag && !drag.moved) select(cellAt(e.offsetX, e.offsetY)); drag = null; });
  canvas.addEventListener('pointercancel', () => { drag = null; });
  canvas.addEventListener('wheel', e => {
    if (!fit) return;
    e.preventDefault();
    const factor = Math.exp(-0.0015 * e.deltaY), [r, z] = back(e.offsetX + MARGIN.left, e.offsetY + MARGIN.top);
    const zoom = Math.min(1e4, Math.max(0.2, state.zoom * factor)), by = state.zoom / zoom;
    state.centre = [r + (fit.centre[0] - r) * by, z + (fit.centre[1] - z) * by];
    state.zoom = zoom; draw();
  }, { passive: false });
  canvas.addEventListener('dblclick', () => { state.zoom = 1; state.centre = null; draw(); });
  canvas.addEventListener('pointerleave', () => { tip.hidden = true; });
  canvas.addEventListener('redraw', draw);
  canvas.addEventListener('keydown', e => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
    if (by) { e.preventDefault(); step(by); }
    if (e.key === ' ') { e.preventDefault(); playing(!state.playing); }
  });
  const hover = e => {
    const cell = cellAt(e.offsetX, e.offsetY), field = fieldOf();
    tip.hidden = cell < 0;
    if (tip.hidden) return;
    const found = store.get(state.frame, state.field), [r, z] = back(e.offsetX + MARGIN.left, e.offsetY + MARGIN.top), values = found && field ? found.values.get(state.field) : null;
    const list = cornersOf(store.mesh, cell), value = !values?.length ? NO_VALUE : field.on_cells ? values[cell] : list.reduce((sum, p) => sum + values[p], 0) / list.length;
    const lines = [value < 1e38 ? `${field.name} ${window.show(value)} ${field.unit}` : null, view.elementName({ mesh: store.mesh, cell }), `r ${window.show(Math.abs(r), 4)}, z ${window.show(z, 4)}`];
    tip.replaceChildren(...lines.filter(Boolean).map(line => make('div', {}, line)));
    tip.style.left = `${e.offsetX + MARGIN.left + 14}px`; tip.style.top = `${e.offsetY + MARGIN.top + 14}px`;
  };
  slider.addEventListener('input', () => { playing(false); follow.checked = false; show(Number(slider.value)); });
  chooser.addEventListener('change', () => setField(Number(chooser.value)));
  follow.addEventListener('change', () => { if (follow.checked) { playing(false); showLast(); } });
  for (const control of [own, edges]) control.addEventListener('change', draw);
  new ResizeObserver(draw).observe(stage);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  const label_ = (control, text) => make('label', {}, control, ` ${text}`);
  const controls = make('div', { class: 'controls' }, play, button('◀', 'previous frame', () => step(-1)), button('▶', 'next frame', () => step(1)), slider, clock);
  const choices = make('div', { class: 'controls' }, chooser, speed, label_(follow, 'newest frame'), label_(own, 'scale of this frame'), label_(edges, 'edges'));
  const hint = make('p', { class: 'soft' }, 'Click on an element for its history. The wheel changes the scale, dragging moves the view, a double click shows all.');
  stage.append(tip, empty);
  /** Takes a new list of frames; another run in the same folder resets the view. */
  const update = restarted => {
    const { times, fields } = parts.frames;
    if (restarted) {
      store.reset(); painted = '';
      Object.assign(state, { frame: 0, field: fields.length ? 0 : -1, choice: null, selected: -1, zoom: 1, centre: null, next: 0 });
      onPick(null);
    }
    if (chooser.length !== fields.length + 1) {
      // Later frames may have more fields; the chosen one remains.
      if (chooser.length === 1 || state.field >= fields.length) state.field = fields.length ? 0 : -1;
      chooser.replaceChildren(make('option', { value: -1 }, 'no field'), ...fields.map((f, i) => make('option', { value: i }, f.name)));
    }
    chooser.value = state.field;
    slider.max = Math.max(0, times.length - 1);
    empty.hidden = times.length > 0;
    if (times.length) { label(); showLast(); }
  };
  return { node: card('', controls, stage, scale, choices, hint), update, show, draw, select, playing, state, drawing, canvas, setField, paint, prefetch, position: (x, y) => back(x + MARGIN.left, y + MARGIN.top) };
}

// ---- the page ----
const view = (() => {
  const badge = make('span', { class: 'badge' }, 'connecting'), bar = make('progress', { max: 1, hidden: '' }), line = make('p', { class: 'line soft' });
  const link = make('a', { href: 'report', target: '_blank' }, 'report page');
  const messages_ = make('div', {}), side = make('div', { class: 'side' }), element = make('div', {}), below = make('div', {}), more = make('div', {});
  const charts = new Map();
  let connected = false, lost = false, local = '';
  const summary = () => parts.run && parts.run.summary ? parts.run.summary : null;
  const facts = () => summary() || parts.setup || {};
  const ended = () => !!(summary() || parts.status.ended);
  const scene = () => facts().scene || null;
  const elementName = ({ mesh, cell }) => mesh.elements[cell] ? `element ${mesh.elements[cell]}` : `cell ${cell + 1}`;
  const material = ({ mesh, cell }) => {
    const number = mesh.materials[cell], name = (facts().materials || [])[number - 1];
    return number ? name || `material ${number}` : 'no material';
  };
  /** Draws a chart, or again with new data, with its zoom and hidden series. */
  const chart = (place, chart, before = false) => {
    const text = JSON.stringify(chart), old = charts.get(chart.title);
    if (old && old.text === text) return;
    const drawn = drawChart(chart);
    if (old) {
      drawn.at.zoom = old.drawn.at.zoom;
      drawn.series.forEach(s => { s.hidden = old.drawn.series.some(o => o.name === s.name && o.hidden); });
      old.drawn.node.replaceWith(drawn.node);
    } else if (before) place.prepend(drawn.node);
    else place.append(drawn.node);
    drawn.draw();
    drawn.setTime(parts.frames.times[mesh.state.frame] ?? null);
    charts.set(chart.title, { text, drawn });
  };
  const drawCharts = () => {
    const all = (parts.run ? parts.run.charts : []).filter(c => c.title !== 'Increment');
    const increments = (parts.run ? parts.run.charts : []).find(c => c.title === 'Increment') || parts.status.increments;
    const first = all.find(c => c.title === 'Energy balance') || all.find(c => c.title === 'Energy');
    if (first) chart(side, first, true);
    if (increments) chart(side, increments);
    for (const other of all) if (other !== first) chart(below, other);
    const present = new Set([...all, increments].filter(Boolean).map(c => c.title));
    for (const [title, { drawn }] of charts) if (!present.has(title) && !title.includes(' of ')) { drawn.node.remove(); charts.delete(title); }
  };
  const drawHead = () => {
    const s = summary(), state = lost ? 'view closed' : s ? s.status : parts.status.ended || (parts.status.last ? 'running' : connected ? 'waiting' : 'connecting');
    badge.textContent = state;
    badge.className = `badge ${state === 'completed' ? 'good' : ['halted', 'view closed'].includes(state) ? 'bad' : 'busy'}`;
    const p = ended() ? null : parts.progress, last = p || parts.status.last;
    bar.hidden = !p;
    if (p) bar.value = p.fraction;
    const time = parts.frames.units[1] ? ` ${parts.frames.units[1]}` : '';
    line.textContent = s && s.timing ? `${s.timing.increments} increments in ${show(s.timing.seconds, 3)} s`
      : last ? [last.step, `time ${show(last.time, 5)}${time}`, `increment ${last.increment}`, `stable increment ${show(last.stable, 3)}${time}`,
        last.element ? `limited by element ${last.element}` : null, p ? `energy drift ${show(100 * p.drift, 2)} %` : `wall time ${last.wall}`].filter(Boolean).join(', ') : '';
  };
  const drawMessages = () => {
    const s = summary(), warnings = s && s.warnings ? s.warnings : parts.warnings, list = (title, kind, texts) => texts.length ? card(title, make('ul', { class: kind }, ...texts.map(w => make('li', {}, w)))) : '';
    messages_.replaceChildren(
      lost ? card('The server of this view has ended', make('p', {}, 'Frames that have been loaded can still be shown. To see the results again: ', make('code', {}, `revolve view ${data.folder}`))) : '',
      parts.changed.length ? card('The deck has changed', make('p', {}, `These results are older than ${parts.changed.join(', ')}. Run the deck again for new ones.`)) : '',
      s && s.reason ? make('div', { class: 'card reason' }, make('h3', {}, 'Halted'), s.reason) : '',
      list('Warnings', 'warning', warnings), list('Files that cannot be read', 'error', [...parts.faults, ...(local ? [local] : [])]));
  };
  const drawFacts = () => {
    const s = facts(), book = ledger(s);
    more.replaceChildren(...[book, energies(s), steps(s), findings(s), messages(s), parts.run ? columns(parts.run) : null].filter(Boolean));
  };
  // ---- the chosen element ----
  let chosen = { choice: null, field: -1, values: [], missing: [], busy: false };
  const drawElement = () => {
    const { choice, values, missing } = chosen;
    if (!choice) { element.replaceChildren(); return; }
    const field = parts.frames.fields[chosen.field], title = field ? `${field.name} of ${elementName(choice)}` : '';
    const close = make('button', { type: 'button' }, 'close');
    close.addEventListener('click', () => mesh.select(-1));
    chosen.table ??= make('div', {});
    const points = values.map((v, i) => [parts.frames.times[i], v]).filter(p => Number.isFinite(p[1]));
    for (const name of [...charts.keys()]) if (name.includes(' of ') && name !== title) charts.delete(name);
    const before = charts.get(title), plot = make('div', {});
    if (before) plot.append(before.drawn.node);
    const reason = missing.length ? make('p', { class: 'soft' }, `${elementName(choice)} is not in ${intervals(missing)}: its body has another mesh there. The history has no values in these frames.`) : null;
    element.replaceChildren(card('', make('div', { class: 'title' }, make('h3', {}, `${elementName(choice)}, ${material(choice)}`), make('span', { class: 'take' }, close)), plot, reason, chosen.table));
    if (field && points.length > 1) {
      chart(plot, { title, x_label: 'time', y_label: field.name, units: [parts.frames.units[1], field.unit], logarithmic: false,
        series: [{ name: field.name, form: 'line', x: points.map(p => p[0]), y: points.map(p => p[1]) }] });
    }
  };
  /** Returns ascending frames, counted from 0, as text: frames 3 to 7, 9. */
  const intervals = frames => {
    const ends = [];
    for (const frame of frames) ends.length && ends.at(-1)[1] === frame - 1 ? ends.at(-1)[1] = frame : ends.push([frame, frame]);
    return `frame${frames.length > 1 ? 's' : ''} ${ends.map(([a, b]) => a === b ? a + 1 : `${a + 1} to ${b + 1}`).join(', ')}`;
  };
  const readState = async () => {
    const { choice } = chosen, frame = mesh.state.frame;
    if (!choice || chosen.frame === frame || mesh.state.playing) return;
    chosen.frame = frame;
    const cell = cellIn(store.mesh, choice);
    if (cell < 0) { chosen.table?.replaceChildren(make('p', { class: 'soft' }, `The mesh of frame ${frame + 1} does not have ${elementName(choice)}.`)); return; }
    try {
      const values = await (await fetch(`state?cell=${cell}&frame=${frame}`)).json();
      if (chosen.choice !== choice || chosen.frame !== frame) return;
      const unit = name => (parts.frames.fields.find(f => f.name === name) || {}).unit || '';
      chosen.table?.replaceChildren(make('p', { class: 'soft' }, `State in frame ${frame + 1}`), factList(values.map(([name, v]) => [name, `${show(v, 5)} ${unit(name)}`])));
    } catch (error) { fault(error.message); }
  };
  /** Reads the values of the chosen field in all frames, a few frames at a time. */
  const readTrace = async () => {
    const it = chosen;
    if (!it.choice || it.busy || it.field < 0) return;
    it.busy = true;
    try {
      while (it === chosen && it.values.length < parts.frames.times.length) {
        const from = it.values.length, { mesh: { number }, cell } = it.choice;
        const bytes = await store.fetchBytes(`trace?mesh=${number}&cell=${cell}&field=${it.field}&from=${from}&to=${parts.frames.times.length}`);
        // Values, then whether the mesh of each frame has the element.
        const count = bytes.byteLength / 5;
        it.values.push(...new Float32Array(bytes, 0, count));
        new Uint8Array(bytes, 4 * count).forEach((has, i) => { if (!has) it.missing.push(from + i); });
        if (it === chosen) drawElement();
      }
    } catch (error) { if (it === chosen) fault(error.message); }
    it.busy = false;
  };
  const pick = choice => {
    chosen = { choice, field: mesh ? mesh.state.field : -1, values: [], missing: [], busy: false, frame: -1, table: null };
    drawElement();
    if (choice) { readState(); readTrace(); }
  };
  let marked = 0;
  const mark = () => {
    clearTimeout(marked);
    marked = 0;
    charts.forEach(({ drawn }) => drawn.setTime(parts.frames.times[mesh.state.frame]));
  };
  const shown = () => {
    // The browser needs more time for the charts than for the mesh: ten times a second are enough while frames are played.
    if (!mesh.state.playing) mark();
    else if (!marked) marked = setTimeout(mark, 100);
    readState();
  };
  const fault = text => { local = text; drawMessages(); };
  let mesh = null;
  mesh = meshView(shown, pick);
  page.replaceChildren(
    make('header', {}, make('h1', {}, data.name), badge, bar, make('span', { class: 'soft' }, `${data.folder} · Revolve ${data.version}`), link), line, messages_,
    make('div', { class: 'live' }, make('div', {}, mesh.node, element), side), below, more);
  below.className = 'charts';
  const received = {
    setup(value) { parts.setup = value; drawFacts(); },
    frames(value) {
      const restarted = value.generation !== parts.frames.generation || value.times.length < parts.frames.times.length || !store.mesh && value.times.length > 0 && !parts.frames.times.length;
      parts.frames = value;
      mesh.update(restarted);
      if (chosen.choice) readTrace();
    },
    status(value) { parts.status = value; drawHead(); drawCharts(); },
    progress(value) { parts.progress = value; drawHead(); },
    warnings(value) { parts.warnings = value; drawMessages(); },
    changed(value) { parts.changed = value; drawMessages(); },
    faults(value) { parts.faults = value; drawMessages(); },
    run(value) { parts.run = value; drawHead(); drawMessages(); drawCharts(); drawFacts(); mesh.draw(); mesh.prefetch(); },
  };
  const events = new EventSource('events');
  for (const [name, act] of Object.entries(received)) events.addEventListener(name, e => act(JSON.parse(e.data)));
  events.addEventListener('open', () => { connected = true; lost = false; drawHead(); drawMessages(); });
  // The browser tries again by itself; a server that has ended never answers.
  events.addEventListener('error', () => { lost = true; drawHead(); drawMessages(); });
  return { mesh, charts, ended, scene, elementName, fault, material, chosen: () => chosen };
})();
