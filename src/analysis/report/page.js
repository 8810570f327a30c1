// Draws the report page from its embedded JSON data (report/data.rs), with the functions of shared.js. No network requests are made.
const data = JSON.parse(document.getElementById('data').textContent);
const NONE = 65535;

function numbers(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Uint16Array(bytes.buffer);
}

// ---- the meridian ----
/** Returns for each frame its mesh, and where its points and cells begin in the packed arrays. */
function framesOf(m) {
  const meshes = [m, ...(m.new_meshes || [])].map(({ points, cells, corners, elements }) => ({ points, cells, elements, corners: numbers(corners) }));
  meshes.forEach(mesh => { mesh.chains = outlines(mesh, mesh.corners, NONE); });
  let point = 0, cell = 0;
  return m.times.map((time, i) => {
    const mesh = meshes[m.mesh_of_frame ? m.mesh_of_frame[i] : 0], frame = { mesh, point, cell };
    point += mesh.points; cell += mesh.cells;
    return frame;
  });
}
/** Frames of the meridian section, mirrored about the axis; z is horizontal if the model is longer than wide. */
function drawMeridian(m, onTime) {
  const places = numbers(m.places), parts = framesOf(m), frames = parts.length;
  const [r0, r1, z0, z1] = m.bounds;
  const fields = m.fields.filter(f => f.name !== 'STATUS').map(f => ({ ...f, at: numbers(f.values) }));
  const status = m.fields.filter(f => f.name === 'STATUS' && f.on_cells).map(f => numbers(f.values))[0];
  const layers = layersOf(m.scene), faces = layers.flatMap(l => [l.from, l.to]).filter(Number.isFinite);
  const canvas = make('canvas', { role: 'img', tabindex: 0, 'aria-label': 'Meridian section, mirrored about the axis' });
  const slider = make('input', { type: 'range', min: 0, max: frames - 1, value: frames - 1, step: 1, 'aria-label': 'frame' });
  const clock = make('output', {}), play = make('button', { type: 'button' }, 'play');
  const chooser = make('select', { 'aria-label': 'field' }, make('option', { value: -1 }, 'no field'), ...fields.map((f, i) => make('option', { value: i }, f.name)));
  const view = make('select', { 'aria-label': 'view' }, make('option', { value: 'all' }, 'whole path'), make('option', { value: 'near' }, 'close to the body'));
  const own = make('input', { type: 'checkbox' }), edges = make('input', { type: 'checkbox' });
  const bar = make('i', { style: { background: `linear-gradient(to right, ${Array.from({ length: 9 }, (_, i) => COLOURS[Math.round(i * 255 / 8)]).join(',')})` } });
  const name = make('b', {}), marks = make('div', { class: 'marks' }), scale = make('div', { class: 'scale' }, name, make('div', { class: 'colours' }, bar, marks));
  const tip = make('div', { class: 'tip', hidden: '' });
  const state = { frame: frames - 1, field: fields.length ? 0 : -1 };
  chooser.value = state.field;
  const point = (frame, p) => {
    const k = 2 * (parts[frame].point + p);
    return [r0 + (r1 - r0) * places[k] / (NONE - 1), z0 + (z1 - z0) * places[k + 1] / (NONE - 1)];
  };
  /** The view: smallest z, largest z, largest r. */
  const window_ = frame => {
    let a = z0, b = z1, r = Math.max(Math.abs(r0), r1);
    if (view.value === 'near') {
      let low = Infinity, high = -Infinity;
      for (let p = 0; p < parts[frame].mesh.points; p++) { const z = point(frame, p)[1]; low = Math.min(low, z); high = Math.max(high, z); }
      const reach = Math.max(high - low, 2 * r);
      [a, b] = [low - 0.2 * reach, high + 0.2 * reach];
    } else {
      const size = Math.max(b - a, 2 * r);
      for (const f of faces) if (f > a - 0.25 * size && f < b + 0.25 * size) { a = Math.min(a, f); b = Math.max(b, f); }
      a -= 0.06 * size; b += 0.06 * size;
    }
    return [a, b, Math.max(1.35 * r, 0.1 * (b - a))];
  };
  // The last frame in which the field is not constant.
  const first = fields[0];
  /** Returns the packed values of a field in a frame. */
  const valuesOf = (field, frame) => {
    const { mesh, point, cell } = parts[frame];
    return field.on_cells ? field.at.subarray(cell, cell + mesh.cells) : field.at.subarray(point, point + mesh.points);
  };
  const flat = frame => { const part = valuesOf(first, frame).filter(v => v !== NONE); return part.every(v => v === part[0]); };
  while (first && state.frame > 0 && flat(state.frame)) state.frame--;
  if (first && flat(state.frame)) state.frame = frames - 1;
  slider.value = state.frame;
  const [lengthUnit, timeUnit] = m.units || ['', ''];
  let project = () => [0, 0], back = () => [0, 0], seen = [];
  const draw = () => {
    const width = canvas.clientWidth || 900, ratio = devicePixelRatio || 1, frame = state.frame;
    const [a, b, r] = window_(frame), long = b - a > 2 * r;
    const spanX = long ? b - a : 2 * r, spanY = long ? 2 * r : b - a;
    const px0 = 54, px1 = width - 18, py0 = 12;
    const unit = Math.min((px1 - px0) / spanX, 520 / spanY), height = Math.round(spanY * unit) + py0 + 44;
    const left = px0 + ((px1 - px0) - spanX * unit) / 2;
    canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio);
    canvas.style.height = `${height}px`;
    const g = canvas.getContext('2d');
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    project = long ? (rr, z) => [left + (z - a) * unit, py0 + (r - rr) * unit] : (rr, z) => [left + (rr + r) * unit, py0 + (b - z) * unit];
    back = long ? (x, y) => [r - (y - py0) / unit, a + (x - left) / unit] : (x, y) => [(x - left) / unit - r, b - (y - py0) / unit];
    const box = [left, py0, spanX * unit, spanY * unit];
    g.save();
    g.beginPath(); g.rect(...box); g.clip();
    drawLayers(g, layers, [a, b, r], project, long);
    drawPlanes(g, m.scene, [a, b, r], project);
    drawAxis(g, [a, b], project);
    const field = fields[state.field], values = field && valuesOf(field, frame);
    drawBodies(g, parts[frame].mesh.chains, p => point(frame, p), project);
    seen = drawCells(g, parts[frame], field, values, status, p => point(frame, p), project, range(field, frame), edges.checked);
    g.restore();
    drawTicks(g, box, long, [a, b, r], project, lengthUnit);
    clock.value = `frame ${frame + 1} of ${frames}, time ${show(m.times[frame], 6)}${timeUnit ? ` ${timeUnit}` : ''}`;
    const [low, high] = range(field, frame);
    scale.hidden = !field;
    if (field) {
      const values = high > low ? [0, 1, 2, 3, 4].map(i => low + (high - low) * i / 4) : [low];
      const written = labels(values);
      name.textContent = withUnit(field.name, field.unit, written.exponent);
      marks.replaceChildren(...written.texts.map(t => make('span', {}, t)));
    }
    onTime(m.times[frame]);
  };
  const range = (field, frame) => {
    if (!field) return [0, 1];
    if (!own.checked) return [field.low, field.high];
    let low = NONE, high = 0;
    for (const v of valuesOf(field, frame)) if (v !== NONE) { low = Math.min(low, v); high = Math.max(high, v); }
    const back = v => field.low + (field.high - field.low) * v / (NONE - 1);
    return low > high ? [field.low, field.high] : [back(low), back(high)];
  };
  const setFrame = frame => { state.frame = Math.min(frames - 1, Math.max(0, frame)); slider.value = state.frame; draw(); };
  slider.addEventListener('input', () => setFrame(Number(slider.value)));
  chooser.addEventListener('change', () => { state.field = Number(chooser.value); draw(); });
  for (const control of [own, edges, view]) control.addEventListener('change', draw);
  canvas.addEventListener('keydown', e => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
    if (step) { e.preventDefault(); setFrame(state.frame + step); }
  });
  let timer = 0;
  play.addEventListener('click', () => {
    if (timer) { clearInterval(timer); timer = 0; play.textContent = 'play'; return; }
    play.textContent = 'stop';
    timer = setInterval(() => setFrame((state.frame + 1) % frames), 120);
  });
  canvas.addEventListener('pointermove', e => {
    const box = canvas.getBoundingClientRect(), x = e.clientX - box.left, y = e.clientY - box.top, field = fields[state.field];
    const hit = seen.find(c => inside(c.shape, x, y));
    tip.hidden = !hit;
    if (tip.hidden) return;
    const [r, z] = back(x, y), element = parts[state.frame].mesh.elements[hit.cell];
    const said = field ? `${field.name} ${show(hit.value)}${hit.value !== null && field.unit ? ` ${field.unit}` : ''}` : null;
    const lines = [said, element ? `element ${element}` : null, `r ${show(Math.abs(r), 4)}, z ${show(z, 4)}${lengthUnit ? ` ${lengthUnit}` : ''}`];
    tip.replaceChildren(...lines.filter(Boolean).map(line => make('div', {}, line)));
    tip.style.left = `${x + 14}px`; tip.style.top = `${y + 14}px`;
  });
  canvas.addEventListener('pointerleave', () => { tip.hidden = true; });
  addEventListener('resize', draw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  addEventListener('beforeprint', draw);
  const label = (control, text) => make('label', {}, control, ` ${text}`);
  const controls = make('div', { class: 'controls' }, play, slider, clock, chooser, view, label(own, 'scale of this frame'), label(edges, 'edges'));
  const node = card('Meridian section, mirrored about the axis', controls, make('div', { class: 'plot' }, canvas, tip), scale);
  return { node, draw, setFrame, drawnCells: () => seen.length, setField: i => { state.field = i; chooser.value = i; draw(); }, frames, fields, canvas };
}
/** Draws cells by colour on both sides of the axis; returns the drawn polygons for the tooltip. */
function drawCells(g, { mesh: { cells, corners }, cell }, field, values, status, point, project, [low, high], edges) {
  const seen = [], plain = ink('--body'), line = ink('--soft'), none = ink('--soft');
  for (let c = 0; c < cells; c++) {
    if (status && status[cell + c] < NONE / 2) continue;
    const list = [0, 1, 2, 3].map(i => corners[4 * c + i]).filter(p => p !== NONE);
    const value = valueOf(field, values, c, list);
    const part = value === null ? 0 : high > low ? (value - low) / (high - low) : 0;
    const paint = !field ? plain : value === null ? none : COLOURS[Math.round(255 * Math.min(1, Math.max(0, part)))];
    for (const side of [1, -1]) {
      const shape = list.map(p => { const [r, z] = point(p); return project(side * r, z); });
      g.beginPath();
      shape.forEach((p, i) => i ? g.lineTo(...p) : g.moveTo(...p));
      if (list.length === 2) {
        g.strokeStyle = field ? paint : line; g.lineWidth = field && value !== null ? 5 : 2; g.lineCap = 'round'; g.stroke();
      } else {
        g.closePath(); g.fillStyle = paint; g.fill();
        // A stroke of the same colour closes the gaps between neighbouring cells.
        g.strokeStyle = edges ? line : paint; g.lineWidth = edges ? 0.5 : 0.7; g.stroke();
      }
      seen.push({ shape, value, cell: c });
    }
  }
  return seen;
}
function valueOf(field, values, cell, list) {
  if (!field) return null;
  const back = v => v === NONE ? null : field.low + (field.high - field.low) * v / (NONE - 1);
  if (field.on_cells) return back(values[cell]);
  const known = list.map(p => back(values[p])).filter(v => v !== null);
  return known.length ? known.reduce((a, b) => a + b) / known.length : null;
}
// ---- sections ----
function drawRun(run) {
  const s = run.summary || {}, section = make('section', { class: 'run' });
  const done = s.status === 'completed';
  section.append(make('div', { class: 'head' }, make('h2', {}, `Run ${run.name}`), make('span', { class: `badge ${done ? 'good' : 'bad'}` }, s.status || 'no summary'),
    s.timing ? make('span', { class: 'soft' }, `${s.timing.increments} increments in ${show(s.timing.seconds, 3)} s`) : null));
  if (s.reason) section.append(make('div', { class: 'card reason' }, make('h3', {}, 'Halted'), s.reason));
  if (s.ended_by_user) section.append(make('div', { class: 'card' }, 'A user subroutine ended the analysis.'));
  if (s.warnings && s.warnings.length) section.append(card('Warnings', make('ul', { class: 'warning' }, ...s.warnings.map(w => make('li', {}, w)))));
  section.append(outcome(run, s));
  if (run.uncertainties) section.append(card('Uncertainty', ...run.uncertainties.map(u => make('p', { class: 'deviation' }, u))));
  if (run.deviations) section.append(card('Compared with a reference', ...run.deviations.map(d => make('p', { class: 'deviation' }, d))));
  const charts = run.charts.map(drawChart);
  const setTime = time => charts.forEach(c => c.setTime(time));
  let meridian = null;
  if (run.meridian) {
    meridian = drawMeridian(run.meridian, setTime);
    section.append(meridian.node);
  }
  section.append(chartGrid(charts));
  section.append(...[energies(s), steps(s), ledger(s), findings(s), messages(s), columns(run)].filter(Boolean));
  if (run.notes.length) section.append(card('Omitted data', notes(run.notes)));
  return { section, meridian, charts };
}
/** Table of removed effects: change of the quantity and saved run time. */
function effects(list) {
  if (!list || !list.length) return null;
  const largest = key => Math.max(1e-12, ...list.map(e => Math.abs(e[key] ?? 0)));
  const [error, saved] = [largest('error'), largest('saved')];
  const bar = (value, most, name) => value === null || value === undefined ? 'no result' : make('span', { class: 'whole' },
    make('i', { class: `bar ${name}`, style: { width: `${Math.max(1, Math.round(60 * Math.abs(value) / most))}px` } }), ` ${show(100 * value, 3)} %`);
  const rows = list.map(e => [e.name, bar(e.error, error, e.matters ? 'bad' : 'soft-bar'), bar(e.saved, saved, e.saved < 0 ? 'bad' : 'good')]);
  return make('div', { class: 'effects' }, card('Removed effects', table(['effect', 'change of the quantity', 'saved run time'], rows),
    make('p', { class: 'soft' }, 'Grey: the change is below the error estimate. Negative: the run takes longer without the effect.')));
}
/** An SVG picture; the style sheet inverts it on a dark page. */
function drawPicture(picture) {
  return { node: make('figure', { class: 'card' }, make('img', { class: 'picture', src: picture.source, alt: picture.name }), make('figcaption', {}, picture.name)) };
}
function drawTable(word, t, pareto = [], list = [], pictures = []) {
  const section = make('section', { class: word.toLowerCase() }, make('div', { class: 'head' }, make('h2', {}, `${word} ${t.name}`)));
  if (t.facts.length) section.append(card('', factList(t.facts)));
  const bars = effects(list);
  if (bars) section.append(bars);
  const charts = t.charts.map(drawChart);
  if (charts.length) section.append(chartGrid(charts));
  if (pictures.length) section.append(chartGrid(pictures.map(drawPicture)));
  const isNumber = i => t.rows.every(row => row[i] === '' || row[i] === '-' || !Number.isNaN(Number(row[i])));
  if (t.rows.length) {
    section.append(card(pareto.some(Boolean) ? 'Settings' : 'Table', table(t.header, t.rows, isNumber, r => pareto[r] ? 'best' : ''),
      pareto.some(Boolean) ? make('p', { class: 'soft' }, 'Marked rows are on the Pareto front of error and run time.') : null));
  }
  if (t.notes.length) section.append(card('Omitted data', notes(t.notes)));
  return { section, charts };
}

// ---- the page ----
page.replaceChildren(make('header', {}, make('h1', {}, data.title), make('span', { class: 'soft' }, `${data.folder} · Revolve ${data.version}`)));
const runs = data.runs.map(drawRun);
const tables = [...data.studies.map(s => drawTable('Study', s.table, s.pareto, s.effects)), ...data.sweeps.map(s => drawTable('Sweep', s)),
  ...data.searches.map(s => drawTable(s.title, s.table, [], [], s.pictures))];
page.append(...tables.map(t => t.section), ...runs.map(r => r.section));
if (data.notes.length) page.append(card('Omitted data', notes(data.notes)));
runs.forEach(r => r.meridian && r.meridian.draw());
const allCharts = [...tables, ...runs].flatMap(t => t.charts);
allCharts.forEach(c => c.draw());
if (location.hash.startsWith('#frame=')) runs.forEach(r => r.meridian && r.meridian.setFrame(Number(location.hash.slice(7)) - 1));
