// Drawing of charts, meridian sections and tables: used by the report page (report/page.js) and by the live view (view/view.js).
'use strict';
const faults = [];
addEventListener('error', e => faults.push(String(e.message)));
addEventListener('securitypolicyviolation', e => faults.push(`policy: ${e.violatedDirective}`));
const page = document.getElementById('page');
// The colour-blind-safe palette of Okabe and Ito, without black and yellow, which are invisible on one of the backgrounds.
const PALETTE = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8c6bb1', '#7f7f7f'];
// The colour map Viridis (Smith and van der Walt) at nine equally spaced values.
const VIRIDIS = ['440154', '472d7b', '3b528b', '2c728e', '21918c', '28ae80', '5ec962', 'addc30', 'fde725']
  .map(h => [0, 2, 4].map(i => parseInt(h.slice(i, i + 2), 16)));

// ---- helper functions ----
function make(tag, attributes = {}, ...children) {
  const svg = ['svg', 'g', 'path', 'line', 'text', 'circle', 'rect'].includes(tag);
  const node = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'style') Object.assign(node.style, value);
    else if (value !== undefined && value !== null) node.setAttribute(key, value);
  }
  node.append(...children.filter(c => c !== undefined && c !== null));
  return node;
}
/** Formats a number with a given number of digits, in plain or scientific form. */
function show(value, digits = 5) {
  if (value === null || value === undefined || Number.isNaN(value)) return 'none';
  if (typeof value !== 'number') return String(value);
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(Math.max(0, digits - 1)).replace(/\.?0+e/, 'e').replace('e+', 'e');
  return String(Number(value.toPrecision(digits)));
}
const raised = number => String(number).replace(/./g, c => '⁰¹²³⁴⁵⁶⁷⁸⁹'[c] ?? '⁻');
/** Returns the common power of ten of an axis, a multiple of three; 0 if plain numbers are short. */
function exponentOf(values) {
  const largest = Math.max(0, ...values.map(Math.abs));
  return largest === 0 || (largest >= 0.1 && largest < 1e4) ? 0 : 3 * Math.floor(Math.log10(largest) / 3 + 1e-9);
}
/** Returns the labels of an axis and their common power of ten. */
function labels(values) {
  const exponent = exponentOf(values);
  return { texts: values.map(v => String(Number((v / 10 ** exponent).toPrecision(4)))), exponent };
}
/** Returns the labels of a logarithmic axis: all plain numbers or all powers of ten. */
function powers(values) {
  if (values.every(v => v >= 1e-3 && v < 1e5)) return { texts: values.map(v => show(v, 3)), exponent: 0 };
  return { exponent: 0, texts: values.map(v => {
    const power = Math.floor(Math.log10(v) + 1e-9), digit = Math.round(v / 10 ** power);
    return `${digit === 1 ? '' : `${digit}·`}10${raised(power)}`;
  }) };
}
const withUnit = (label, unit, exponent = 0) => [label, [exponent ? `10${raised(exponent)}` : '', unit].filter(Boolean).join(' ')].filter(Boolean).join(', ');
/** Returns round ticks that divide an interval. */
function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map(f => f * power).find(s => s >= raw * 0.999);
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) list.push(i * step);
  return list;
}
/** Returns the powers of ten between two logarithms, with intermediate values if there are few. */
function decades(low, high) {
  if (high - low < 1) return ticks(10 ** low, 10 ** high, 4).filter(v => v > 0).map(Math.log10);
  const list = [];
  for (let p = Math.floor(low); p <= Math.ceil(high); p++) {
    for (const f of high - low < 3 ? [1, 2, 5] : [1]) {
      const v = p + Math.log10(f);
      if (v >= low - 1e-9 && v <= high + 1e-9) list.push(v);
    }
  }
  return list;
}
function colour(part) {
  const x = Math.min(1, Math.max(0, part)) * (VIRIDIS.length - 1), i = Math.min(VIRIDIS.length - 2, Math.floor(x));
  const mix = VIRIDIS[i].map((v, k) => Math.round(v + (VIRIDIS[i + 1][k] - v) * (x - i)));
  return `rgb(${mix.join(',')})`;
}
const COLOURS = Array.from({ length: 256 }, (_, i) => colour(i / 255));
const ink = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
function table(header, rows, isNumber = () => false, rowClass = () => '') {
  const cell = (tag, content, i) => {
    const node = make(tag, { class: isNumber(i) ? 'number' : undefined });
    node.append(content instanceof Node ? content : String(content));
    return node;
  };
  const head = make('tr', {}, ...header.map((h, i) => cell('th', h, i)));
  const lines = rows.map((row, r) => make('tr', { class: rowClass(r) || undefined }, ...row.map((c, i) => cell('td', c, i))));
  return make('div', { class: 'scroll' }, make('table', {}, make('thead', {}, head), make('tbody', {}, ...lines)));
}
function card(title, ...children) {
  return make('div', { class: 'card' }, title ? make('h3', {}, title) : null, ...children);
}
function factList(pairs) {
  return make('dl', { class: 'facts' }, ...pairs.map(([name, value]) => make('div', {}, make('dt', {}, name), make('dd', {}, value))));
}
function notes(list) {
  return list && list.length ? make('ul', { class: 'notes' }, ...list.map(n => make('li', {}, n))) : null;
}

// ---- charts ----
const LEFT = 62, RIGHT = 16, TOP = 8, BOTTOM = 42;
/** Returns lower and upper edges of stacked areas, for their positive and negative parts. */
function stack(series) {
  const reached = [[], []];
  for (const s of series.filter(s => s.form === 'area' && !s.hidden)) {
    s.edges = [1, -1].map((sign, below) => s.y.map((v, i) => {
      const from = reached[below][i] ?? 0, to = from + (v * sign > 0 ? v : 0);
      reached[below][i] = to;
      return [from, to];
    }));
  }
}
/** Returns the range of values with a margin. */
function extent(all, tight) {
  const low = all.reduce((a, b) => Math.min(a, b), Infinity), high = all.reduce((a, b) => Math.max(a, b), -Infinity);
  const margin = high > low ? 0.05 * (high - low) : 0.5 * Math.abs(high) || 0.5;
  return tight ? [low, high > low ? high : low + margin] : [low - margin, high + margin];
}
/** A chart with a tooltip. Dragging over a part zooms in, a double click shows the whole chart. `setTime` moves a mark along
 * a time axis. Letters have one size on any screen: the chart is drawn anew where its width changes. */
function drawChart(chart) {
  const log = chart.logarithmic, value = v => log ? Math.log10(v) : v, back = v => log ? 10 ** v : v;
  const series = chart.series.map((s, i) => ({ ...s, colour: s.form === 'guide' && chart.series[0].form === 'area' ? 'currentColor' : PALETTE[i % PALETTE.length], dashes: s.form === 'guide' ? '5 4' : i < PALETTE.length ? null : '9 3' }));
  const svg = make('svg', { role: 'img', tabindex: 0, 'aria-label': `${chart.title}: ${chart.y_label} over ${chart.x_label}` });
  const tip = make('div', { class: 'tip', hidden: '' }), plot = make('div', { class: 'plot' }, svg, tip);
  const now = make('line', { class: 'now', visibility: 'hidden' }), cursor = make('line', { class: 'cursor', visibility: 'hidden' });
  const rubber = make('rect', { class: 'rubber', visibility: 'hidden' });
  const whole = make('button', { type: 'button', title: 'show the whole chart (double click, Escape)', hidden: '' }, 'whole');
  const at = { width: 520, height: 290, zoom: null, time: null };
  const inner = () => [at.width - LEFT - RIGHT, at.height - TOP - BOTTOM];
  at.px = v => LEFT + (value(v) - at.x[0]) / (at.x[1] - at.x[0]) * inner()[0];
  at.py = v => at.height - BOTTOM - (value(v) - at.y[0]) / (at.y[1] - at.y[0]) * inner()[1];
  at.toX = x => at.x[0] + (x - LEFT) / inner()[0] * (at.x[1] - at.x[0]);
  at.toY = y => at.y[0] + (at.height - BOTTOM - y) / inner()[1] * (at.y[1] - at.y[0]);
  const ranges = () => {
    const seen = x => !at.zoom || (value(x) >= at.zoom.x[0] && value(x) <= at.zoom.x[1]);
    const ys = s => s.form === 'area' ? s.hidden ? [] : s.edges.flatMap(edge => edge.filter((_, i) => seen(s.x[i])).flat()) : s.y.filter((_, i) => seen(s.x[i])).map(value);
    at.x = at.zoom ? at.zoom.x : extent(series.flatMap(s => s.x.map(value)).filter(Number.isFinite), series.every(s => s.form !== 'marks'));
    const visible = series.flatMap(ys).filter(Number.isFinite);
    at.y = at.zoom && at.zoom.y ? at.zoom.y : extent(visible.length ? visible : [0, 1], false);
  };
  const draw = () => {
    at.width = Math.max(240, plot.clientWidth || at.width); at.height = at.width < 440 ? 250 : 290;
    stack(series); ranges();
    svg.setAttribute('viewBox', `0 0 ${at.width} ${at.height}`);
    svg.replaceChildren(...drawAxes(chart, at, back));
    const [wide, high] = inner();
    const curves = make('svg', { x: LEFT, y: TOP, width: wide, height: high, viewBox: `${LEFT} ${TOP} ${wide} ${high}`, overflow: at.zoom ? 'hidden' : 'visible' });
    // Lines are drawn over areas.
    for (const s of [...series].sort((a, b) => (b.form === 'area') - (a.form === 'area'))) curves.append(s.group = drawSeries(s, at));
    for (const line of [now, cursor]) { line.setAttribute('y1', TOP); line.setAttribute('y2', at.height - BOTTOM); }
    cursor.setAttribute('visibility', 'hidden');
    svg.append(curves, now, cursor, rubber);
    whole.hidden = !at.zoom;
    setTime(at.time);
  };
  const setTime = time => {
    at.time = time;
    const x = time === null || chart.x_label !== 'time' ? NaN : at.px(time), there = x >= LEFT - 1 && x <= at.width - RIGHT + 1;
    now.setAttribute('visibility', there ? 'visible' : 'hidden');
    if (there) { now.setAttribute('x1', x); now.setAttribute('x2', x); }
  };
  const zoom = part => { at.zoom = part; draw(); };
  whole.addEventListener('click', () => zoom(null));
  dragging(svg, rubber, at, zoom);
  follow(svg, tip, cursor, series, chart, at);
  const legend = make('div', { class: 'legend' }, ...series.map(s => {
    const mark = make('i', s.form === 'marks' ? { class: 'dot', style: { background: s.colour } } : s.form === 'area' ? { class: 'block', style: { background: s.colour } }
      : { style: { borderColor: s.colour, borderTopStyle: s.dashes ? 'dashed' : 'solid' } });
    const entry = make('button', { type: 'button', 'aria-pressed': 'true', title: 'show or hide' }, mark, s.name);
    entry.addEventListener('click', () => {
      s.hidden = !s.hidden;
      entry.setAttribute('aria-pressed', String(!s.hidden));
      draw();
    });
    return entry;
  }));
  const takeAway = make('span', { class: 'take' }, whole,
    download('CSV', () => new Blob([csvOf(chart)], { type: 'text/csv' }), `${fileName(chart.title)}.csv`),
    download('PNG', () => pngOf(svg, at), `${fileName(chart.title)}.png`));
  const title = make('h3', { title: chart.words }, chart.title, make('small', {}, chart.words ? ` ${chart.words}` : ''));
  draw();
  // In the next frame: a drawing within the observer would change the sizes that it observes.
  const fit = () => { if (plot.clientWidth && Math.abs(plot.clientWidth - at.width) > 1) draw(); };
  new ResizeObserver(() => requestAnimationFrame(fit)).observe(plot);
  return { node: make('figure', { class: 'card', style: { margin: '0' } }, make('div', { class: 'title' }, title, takeAway), legend, plot), setTime, draw, at, series };
}
/** Draws grid, ticks and labels of both axes. */
function drawAxes(chart, at, back) {
  const log = chart.logarithmic, right = at.width - RIGHT, bottom = at.height - BOTTOM, parts = [];
  const xs = log ? decades(...at.x) : ticks(...at.x, at.width < 440 ? 4 : 6), ys = log ? decades(...at.y) : ticks(...at.y, 5);
  const [xLabels, yLabels] = [xs, ys].map(list => (log ? powers : labels)(list.map(back)));
  const [xUnit, yUnit] = chart.units || ['', ''];
  ys.forEach((t, i) => {
    const y = at.py(back(t));
    parts.push(make('line', { class: 'grid', x1: LEFT, x2: right, y1: y, y2: y }), make('text', { class: 'tick', x: LEFT - 7, y: y + 4, 'text-anchor': 'end' }, yLabels.texts[i]));
  });
  xs.forEach((t, i) => {
    const x = at.px(back(t));
    parts.push(make('line', { class: 'grid', x1: x, x2: x, y1: TOP, y2: bottom }), make('text', { class: 'tick', x, y: bottom + 17, 'text-anchor': 'middle' }, xLabels.texts[i]));
  });
  parts.push(make('line', { class: 'axis', x1: LEFT, x2: right, y1: bottom, y2: bottom }));
  parts.push(make('line', { class: 'axis', x1: LEFT, x2: LEFT, y1: TOP, y2: bottom }));
  const middle = (TOP + bottom) / 2;
  parts.push(make('text', { x: (LEFT + right) / 2, y: at.height - 7, 'text-anchor': 'middle' }, withUnit(chart.x_label, xUnit, xLabels.exponent)));
  parts.push(make('text', { class: 'y-label', x: 12, y: middle, 'text-anchor': 'middle', transform: `rotate(-90 12 ${middle})` }, withUnit(chart.y_label, yUnit, yLabels.exponent)));
  return parts;
}
function drawSeries(s, at) {
  const group = make('g', { visibility: s.hidden ? 'hidden' : 'visible' });
  if (s.hidden) return group;
  const word = points => 'M' + points.map(p => p.map(v => v.toFixed(1)).join(' ')).join('L');
  if (s.form === 'area') {
    for (const edge of s.edges.filter(edge => edge.some(([from, to]) => from !== to))) {
      const side = k => s.x.map((x, i) => [at.px(x), at.py(edge[i][k])]);
      group.append(make('path', { class: 'area', fill: s.colour, d: `${word([...side(1), ...side(0).reverse()])}Z` }));
    }
    return group;
  }
  const points = s.x.map((x, i) => [at.px(x), at.py(s.y[i])]).filter(p => p.every(Number.isFinite));
  if (s.form !== 'marks' && points.length > 1) {
    group.append(make('path', { class: 'series', fill: 'none', stroke: s.colour, 'stroke-width': s.form === 'guide' ? 1.3 : 2, 'stroke-linejoin': 'round', 'stroke-dasharray': s.dashes, d: word(points) }));
  }
  if (s.form === 'marks' || (s.form === 'line' && points.length <= 25)) {
    for (const [x, y] of points) group.append(make('circle', { class: 'point', cx: x, cy: y, r: s.form === 'line' ? 3 : 4, fill: s.colour }));
  }
  return group;
}
/** Dragging zooms to a box, or to an interval of the abscissa if the drag is horizontal. */
function dragging(svg, rubber, at, zoom) {
  const ENOUGH = 8;
  let from = null;
  const place = e => {
    const box = svg.getBoundingClientRect();
    return [Math.min(at.width - RIGHT, Math.max(LEFT, (e.clientX - box.left) / box.width * at.width)),
      Math.min(at.height - BOTTOM, Math.max(TOP, (e.clientY - box.top) / box.height * at.height))];
  };
  const part = to => {
    const [x, y] = [0, 1].map(k => [from[k], to[k]].sort((a, b) => a - b));
    return { x, y: y[1] - y[0] > 2 * ENOUGH ? y : [TOP, at.height - BOTTOM], level: y[1] - y[0] <= 2 * ENOUGH };
  };
  const end = () => { from = null; rubber.setAttribute('visibility', 'hidden'); };
  svg.addEventListener('pointerdown', e => {
    if (e.button !== 0) return;
    from = place(e);
    if (e.isTrusted) svg.setPointerCapture(e.pointerId);
  });
  svg.addEventListener('pointermove', e => {
    if (!from) return;
    const { x, y } = part(place(e));
    for (const [key, v] of Object.entries({ x: x[0], y: y[0], width: x[1] - x[0], height: y[1] - y[0], visibility: x[1] - x[0] > ENOUGH ? 'visible' : 'hidden' })) rubber.setAttribute(key, v);
  });
  svg.addEventListener('pointerup', e => {
    if (!from) return;
    const { x, y, level } = part(place(e));
    end();
    if (x[1] - x[0] > ENOUGH) zoom({ x: x.map(at.toX), y: level ? null : [at.toY(y[1]), at.toY(y[0])] });
  });
  svg.addEventListener('pointercancel', end);
  svg.addEventListener('dblclick', () => zoom(null));
  svg.addEventListener('keydown', e => { if (e.key === 'Escape') zoom(null); });
}
const fileName = title => title.replace(/[^\w.-]+/g, '_') || 'chart';
/** A button that saves the result of `make`, a blob or a promise of one. */
function download(word, contents, name) {
  const button = make('button', { type: 'button', title: `save as ${word}` }, word);
  button.addEventListener('click', async () => {
    const link = make('a', { download: name, href: URL.createObjectURL(await contents()) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  return button;
}
/** Returns the points of a chart as CSV: the abscissa and one column per series. */
function csvOf(chart) {
  const quoted = text => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  const all = [...new Set(chart.series.flatMap(s => s.x))].sort((a, b) => a - b);
  const columns = chart.series.map(s => new Map(s.x.map((x, i) => [x, s.y[i]])));
  const rows = all.map(x => [x, ...columns.map(c => c.get(x) ?? '')].join(','));
  return [[chart.x_label, ...chart.series.map(s => s.name)].map(quoted).join(','), ...rows].join('\n') + '\n';
}
/** Returns a chart as PNG, scaled by two, with the colours of the page. */
function pngOf(svg, at) {
  const copy = svg.cloneNode(true), scale = 2;
  const from = [svg, ...svg.querySelectorAll('*')], to = [copy, ...copy.querySelectorAll('*')];
  from.forEach((node, i) => {
    const style = getComputedStyle(node);
    for (const key of ['fill', 'fill-opacity', 'stroke', 'stroke-width', 'stroke-dasharray', 'font-size', 'visibility', 'opacity']) to[i].style[key] = style.getPropertyValue(key);
    if (node.tagName === 'text') to[i].style.fontFamily = 'sans-serif';
  });
  copy.setAttribute('width', at.width * scale); copy.setAttribute('height', at.height * scale);
  const image = new Image();
  return new Promise((resolve, reject) => {
    image.onload = () => {
      const canvas = make('canvas', { width: at.width * scale, height: at.height * scale }), g = canvas.getContext('2d');
      g.fillStyle = ink('--card'); g.fillRect(0, 0, canvas.width, canvas.height);
      g.drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob(resolve, 'image/png');
    };
    image.onerror = reject;
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(copy))}`;
  });
}
/** The tooltip follows the pointer, or the arrow keys if the chart has the focus. */
function follow(svg, tip, cursor, series, chart, at) {
  const stops = [...new Set(series.flatMap(s => s.x))].sort((a, b) => a - b);
  const nearest = (list, x) => list.reduce((best, v, i) => Math.abs(at.px(v) - x) < Math.abs(at.px(list[best]) - x) ? i : best, 0);
  let stop = -1;
  const showAt = index => {
    stop = Math.min(stops.length - 1, Math.max(0, index));
    const x = stops[stop], place = at.px(x);
    cursor.setAttribute('x1', place); cursor.setAttribute('x2', place); cursor.setAttribute('visibility', 'visible');
    tip.replaceChildren(make('div', {}, make('b', {}, `${chart.x_label} ${show(x, 6)}`)));
    for (const s of series.filter(s => !s.hidden)) {
      const i = nearest(s.x, place);
      if (!s.x.length || Math.abs(at.px(s.x[i]) - place) > (s.form === 'marks' ? 1 : 8)) continue;
      const words = s.words && s.words[i] ? `: ${s.words[i]}` : '';
      tip.append(make('div', {}, make('i', { style: { background: s.colour } }), `${s.name} ${show(s.y[i], 6)}${words}`));
    }
    tip.hidden = false;
    const left = place / at.width * svg.clientWidth, width = tip.offsetWidth;
    tip.style.left = `${Math.max(0, left + width + 16 <= svg.clientWidth ? left + 12 : Math.min(left - width - 12, svg.clientWidth - width))}px`;
    tip.style.top = `${TOP + 4}px`;
  };
  const hide = () => { tip.hidden = true; cursor.setAttribute('visibility', 'hidden'); };
  svg.addEventListener('pointermove', e => {
    const box = svg.getBoundingClientRect();
    if (stops.length) showAt(nearest(stops, (e.clientX - box.left) / box.width * at.width));
  });
  svg.addEventListener('pointerleave', hide);
  svg.addEventListener('blur', hide);
  svg.addEventListener('keydown', e => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
    if (step && stops.length) { e.preventDefault(); showAt(stop + step * (e.shiftKey ? 10 : 1)); }
  });
}
function chartGrid(charts) {
  return make('div', { class: charts.length === 1 ? 'charts single' : 'charts' }, ...charts.map(c => c.node));
}

// ---- parts of a meridian section ----
/** Layers of targets as intervals of z. */
function layersOf(scene) {
  return ((scene && scene.targets) || []).flatMap(t => {
    let z = t.front;
    return t.layers.map((layer, i) => {
      const from = z;
      z += t.direction * (layer.thickness ?? Infinity);
      return { from, to: z, name: `${t.name}${t.layers.length > 1 ? ` ${i + 1}` : ''}: ${layer.material}` };
    });
  });
}
function drawLayers(g, layers, [a, b, r], project, long) {
  layers.forEach((layer, i) => {
    const low = Math.max(a, Math.min(layer.from, layer.to)), high = Math.min(b, Math.max(layer.from, layer.to));
    if (low >= high) return;
    const [x0, y0] = project(r, low), [x1, y1] = project(-r, high);
    g.globalAlpha = i % 2 ? 0.6 : 1;
    g.fillStyle = ink('--target');
    g.fillRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
    g.globalAlpha = 1;
    g.strokeStyle = ink('--target-line'); g.lineWidth = 1.2;
    for (const z of [layer.from, layer.to]) {
      if (z < a || z > b) continue;
      g.beginPath(); g.moveTo(...project(r, z)); g.lineTo(...project(-r, z)); g.stroke();
    }
    g.fillStyle = ink('--soft'); g.font = '12px system-ui, sans-serif'; g.textAlign = 'left';
    g.fillText(layer.name, Math.min(x0, x1) + 8, Math.max(y0, y1) - 8);
  });
}
function drawPlanes(g, scene, [a, b, r], project) {
  for (const plane of (scene && scene.planes) || []) {
    if (plane.height < a || plane.height > b) continue;
    g.strokeStyle = ink('--target-line'); g.lineWidth = 2; g.setLineDash(plane.carried_by ? [6, 4] : []);
    g.beginPath(); g.moveTo(...project(r, plane.height)); g.lineTo(...project(-r, plane.height)); g.stroke();
    g.setLineDash([]);
  }
  for (const surface of (scene && scene.surfaces) || []) {
    g.strokeStyle = ink('--target-line'); g.lineWidth = 2; g.setLineDash(surface.carried_by ? [6, 4] : []);
    for (const side of [1, -1]) {
      g.beginPath();
      surface.points.forEach(([x, z], i) => g[i ? 'lineTo' : 'moveTo'](...project(side * x, z)));
      g.stroke();
    }
    g.setLineDash([]);
  }
}
function drawAxis(g, [a, b], project) {
  g.strokeStyle = ink('--soft'); g.lineWidth = 1; g.setLineDash([10, 3, 2, 3]);
  g.beginPath(); g.moveTo(...project(0, a)); g.lineTo(...project(0, b)); g.stroke();
  g.setLineDash([]);
}
/** Joins the facets of rigid bodies into outlines: lists of points. A facet is a cell whose third corner is `none`. */
function outlines(m, corners, none) {
  const next = new Map();
  const add = (p, q) => next.set(p, [...(next.get(p) || []), q]);
  for (let c = 0; c < m.cells; c++) {
    if (corners[4 * c + 2] === none) { add(corners[4 * c], corners[4 * c + 1]); add(corners[4 * c + 1], corners[4 * c]); }
  }
  const chains = [], used = new Set();
  const starts = [...next.keys()].sort((p, q) => next.get(p).length - next.get(q).length);
  for (const start of starts) {
    if (used.has(start)) continue;
    const chain = [start];
    used.add(start);
    for (let p = start; ;) {
      p = next.get(p).find(q => !used.has(q));
      if (p === undefined) break;
      used.add(p); chain.push(p);
    }
    if (chain.length > 2 && next.get(start).includes(chain.at(-1))) chain.closed = true;
    chains.push(chain);
  }
  return chains;
}
/** Draws rigid bodies, filled if the outline meets the axis or is closed. */
function drawBodies(g, chains, point, project) {
  g.fillStyle = ink('--body');
  for (const chain of chains) {
    const line = chain.map(point), small = 1e-3 * Math.max(...line.map(p => p[0]));
    const meets = Math.min(line[0][0], line.at(-1)[0]) <= small;
    if (!meets && !chain.closed) continue;
    const mirrored = line.map(([r, z]) => [-r, z]).reverse();
    for (const shape of chain.closed ? [line, mirrored] : [line[0][0] <= small ? [...mirrored, ...line] : [...line, ...mirrored]]) {
      g.beginPath();
      shape.forEach((p, i) => i ? g.lineTo(...project(...p)) : g.moveTo(...project(...p)));
      g.closePath(); g.fill();
    }
  }
}
/** Returns whether a point is inside a polygon, or near a line. */
function inside(shape, x, y) {
  if (shape.length === 2) {
    const [[ax, ay], [bx, by]] = shape, l = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
    const t = Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / l));
    return Math.hypot(x - ax - t * (bx - ax), y - ay - t * (by - ay)) < 5;
  }
  let within = false;
  for (let i = 0, j = shape.length - 1; i < shape.length; j = i++) {
    const [xi, yi] = shape[i], [xj, yj] = shape[j];
    if ((yi > y) !== (yj > y) && x < (xj - xi) * (y - yi) / (yj - yi) + xi) within = !within;
  }
  return within;
}
function drawTicks(g, [x, y, w, h], long, [a, b, r], project, unit) {
  g.strokeStyle = ink('--line'); g.lineWidth = 1; g.strokeRect(x, y, w, h);
  g.fillStyle = ink('--soft'); g.font = '11.5px system-ui, sans-serif';
  const zs = ticks(a, b, Math.max(3, Math.round((long ? w : h) / 110))), rs = ticks(-r, r, Math.max(4, Math.round((long ? h : w) / 45)));
  const below = (v, text) => { g.textAlign = 'center'; g.fillText(text, v, y + h + 16); };
  const beside = (v, text) => { g.textAlign = 'right'; g.fillText(text, x - 6, v + 4); };
  // Both axes have the same scale and the same power of ten.
  const both = labels([...zs, ...rs.map(Math.abs)]), zLabels = both.texts.slice(0, zs.length), rLabels = both.texts.slice(zs.length);
  zs.forEach((z, i) => { const p = project(0, z); long ? below(p[0], zLabels[i]) : beside(p[1], zLabels[i]); });
  rs.forEach((v, i) => { const p = project(v, a); long ? beside(p[1], rLabels[i]) : below(p[0], rLabels[i]); });
  g.textAlign = 'center';
  g.fillText(withUnit(long ? 'z' : 'r', unit, both.exponent), x + w / 2, y + h + 34);
  g.fillText(long ? 'r' : 'z', Math.max(8, x - 44), y + h / 2);
}

// ---- sections of a run ----
function outcome(run, s) {
  const facts = [];
  for (const rest of s.rests || []) facts.push([`${rest.body} at rest`, `time ${show(rest.time)}, displacement ${show(rest.displacement)}`]);
  for (const c of run.columns.filter(c => c.name.includes('@')).slice(0, 6)) facts.push([c.name, show(c.final, 6)]);
  if (s.energy) facts.push(['energy drift', `${show(100 * s.energy.drift, 2)} %`]);
  if (s.deleted_elements) facts.push(['deleted elements', s.deleted_elements]);
  const parameters = Object.entries((s.deck && s.deck.parameters) || {}).slice(0, 40).map(([name, value]) => [name, show(value)]);
  const digest = s.digest ? `. Digest of the final state ${s.digest.slice(0, 16)}…` : '';
  const files = s.deck && s.deck.files ? make('p', { class: 'soft', title: s.digest }, `Deck ${s.deck.files.join(', ')}${digest}`) : null;
  const given = parameters.length ? make('details', {}, make('summary', {}, `Parameters of the deck (${parameters.length})`), factList(parameters)) : null;
  const ways = (s.unfinished || []).map(way => make('p', { class: 'warning' }, way));
  return facts.length || files ? card('Results', factList(facts), ...ways, given, files) : '';
}
function energies(s) {
  if (!s.energy) return null;
  const words = { ALLKE: 'kinetic', ALLIE: 'internal', ALLSE: 'recoverable strain', ALLPD: 'plastic', ALLAE: 'artificial (hourglass)', ALLVD: 'bulk viscosity', ALLFD: 'friction', ALLCW: 'contact', ALLPW: 'penalty springs of contact', ALLCAV: 'opening the cavity', ALLWK: 'work of loads and motions', ETOTAL: 'sum', initial: 'sum at the start' };
  const largest = Math.max(...Object.keys(words).map(key => Math.abs(s.energy[key] || 0)));
  const parts = Object.entries(words).filter(([key]) => Math.abs(s.energy[key]) > 1e-12 * largest);
  const bar = value => make('i', { class: 'bar', style: { width: `${Math.round(260 * Math.abs(value) / largest)}px` } });
  return card('Energy balance at the end', table(['energy', '', 'value', ''], parts.map(([key, word]) => [key, word, show(s.energy[key], 6), bar(s.energy[key])]), i => i === 2),
    make('p', { class: 'soft' }, `The sum changed by at most ${show(s.energy.drift, 2)} of the energy put in.`));
}
function steps(s) {
  if (!s.steps || !s.steps.length) return null;
  const scaled = s.steps.some(t => t.added_mass !== undefined), global = s.steps.some(t => t.global_estimates !== undefined);
  const header = ['step', 'increments', 'time reached', 'smallest increment', 'largest increment', 'limited by'];
  const rows = s.steps.map(t => [t.name, t.increments, show(t.time), show(t.smallest_increment), show(t.largest_increment), t.limiting_element ? `element ${t.limiting_element}` : 'no element']
    .concat(scaled ? [show(t.added_mass)] : [], global ? [t.global_estimates ?? ''] : []));
  return card('Increments', table([...header, ...scaled ? ['added mass'] : [], ...global ? ['global estimates'] : []], rows, i => i > 0 && i !== 5));
}
function ledger(s) {
  if (!s.ledger) return null;
  const bytes = row => row.arrays.reduce((sum, a) => sum + a[1], 0);
  const share = row => row.share === undefined ? '' : make('span', { class: 'whole' }, make('i', { class: 'bar', style: { width: `${Math.round(60 * row.share)}px` } }), `${Math.round(100 * row.share)} %`);
  const arrays = row => row.arrays.map(a => `${a[0]} ${a[1]}`).join(', ');
  const places = row => make('span', {}, ...row.asked_by.flatMap((p, i) => [i ? ', ' : '', make('code', {}, p)]));
  const rows = s.ledger.effects.map(row => [row.effect, `${row.count} ${row.unit}`, places(row), make('span', { title: arrays(row) }, String(bytes(row))), share(row), row.detail]);
  const unused = (s.ledger.unused || []).map(u => `not used: ${u.what} (${u.asked_by}): ${u.why}`);
  return card('Ledger: simulated effects and the cards that request them', table(['effect', 'count', 'requested by', 'bytes', 'time', 'detail'], rows, i => i === 3), notes(unused));
}
function findings(s) {
  if (!s.diagnostics || !s.diagnostics.length) return null;
  const rows = s.diagnostics.map(d => [make('span', { class: d.severity }, `${d.severity} ${d.code}`), make('code', {}, d.place || ''), d.message + (d.help ? ` (${d.help})` : '')]);
  return card('Diagnostics', table(['', 'location', 'message'], rows));
}
function messages(s) {
  if (!s.messages || !s.messages.length) return null;
  return card('Messages of user subroutines', table(['level', 'message', 'times'], s.messages.map(m => [m.level, m.text, m.times ?? 1])));
}
function columns(run) {
  if (!run.columns.length) return null;
  const rows = run.columns.map(c => [c.name, show(c.final, 7), show(c.min, 7), show(c.max, 7)]);
  return make('div', { class: 'card' }, make('details', rows.length <= 12 ? { open: '' } : {}, make('summary', {}, `History columns (${rows.length})`), table(['column', 'final', 'min', 'max'], rows, i => i > 0)));
}
