// Tests of a report page, evaluated in it by the browser: it reads the top-level names of src/analysis/report/page.js.
/** Returns the contrast of a text with its background as defined by WCAG 2; opacity is taken into account. */
function contrastOf(node) {
  const parse = text => text.match(/[\d.]+/g).map(Number).map((v, i) => text.startsWith('color(srgb') && i < 3 ? 255 * v : v);
  const over = ([r, g, b, a = 1], ground) => [r, g, b].map((v, i) => a * v + (1 - a) * ground[i]);
  let ground = [255, 255, 255];
  const line = [];
  for (let n = node; n; n = n.parentElement) line.unshift(n);
  let opacity = 1;
  for (const n of line) { ground = over(parse(getComputedStyle(n).backgroundColor), ground); opacity *= Number(getComputedStyle(n).opacity); }
  const style = getComputedStyle(node), [r, g, b, a = 1] = parse(node.ownerSVGElement ? style.fill : style.color);
  const light = c => c.map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4).reduce((s, v, i) => s + v * [0.2126, 0.7152, 0.0722][i], 0);
  const [x, y] = [light(over([r, g, b, a * opacity], ground)), light(ground)].sort((p, q) => q - p);
  return (x + 0.05) / (y + 0.05);
}
/** Operates all controls of the page; returns the results as JSON. */
function selfTest() {
  const print = canvas => {
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    let sum = 0;
    for (let i = 0; i < pixels.length; i += 4) sum = (sum * 31 + pixels[i] * 65536 + pixels[i + 1] * 256 + pixels[i + 2]) % 2147483647;
    return sum;
  };
  const meridians = runs.filter(r => r.meridian).map(({ meridian: m }) => {
    const prints = [], cells = [];
    for (let i = 0; i < m.frames; i++) { m.setFrame(i); prints.push(print(m.canvas)); cells.push(m.drawnCells()); }
    const byField = m.fields.map((_, i) => { m.setField(i); return print(m.canvas); });
    return { frames: m.frames, cells, different_frames: new Set(prints).size, fields: m.fields.map(f => f.name), different_fields: new Set(byField).size };
  });
  const plots = [...document.querySelectorAll('.plot > svg')];
  const tips = plots.map(svg => {
    svg.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight' }));
    return svg.nextSibling.textContent;
  });
  const texts = [...document.querySelectorAll('body *')].filter(n => [...n.childNodes].some(c => c.nodeType === 3 && c.data.trim()) && !['SCRIPT', 'STYLE', 'OPTION'].includes(n.tagName) && n.getClientRects().length);
  const scaleOf = n => n.ownerSVGElement ? n.ownerSVGElement.clientWidth / n.ownerSVGElement.viewBox.baseVal.width : 1;
  const sizes = texts.map(n => parseFloat(getComputedStyle(n).fontSize) * scaleOf(n));
  const contrasts = texts.map(n => [contrastOf(n), `${n.tagName} ${n.textContent.slice(0, 20)}`]).sort((a, b) => a[0] - b[0]);
  const wide = [...document.querySelectorAll('body *')].filter(n => !n.closest('.scroll') && !n.closest('svg') && n.getBoundingClientRect().right > innerWidth + 1).map(n => n.className || n.tagName);
  const zooms = allCharts.map(({ node, at }) => {
    const svg = node.querySelector('.plot > svg'), box = svg.getBoundingClientRect(), span = () => at.x[1] - at.x[0], before = span();
    const pointer = (type, part) => svg.dispatchEvent(new PointerEvent(type, { button: 0, clientX: box.left + part * box.width, clientY: box.top + 0.5 * box.height }));
    pointer('pointerdown', 0.4); pointer('pointermove', 0.6); pointer('pointerup', 0.6);
    const near = span() / before;
    svg.dispatchEvent(new MouseEvent('dblclick'));
    return [near, span() / before];
  });
  const entry = document.querySelector('.legend button');
  entry?.click();
  const shown = run => run.charts.flatMap(c => [...c.node.querySelectorAll('svg svg g')]).filter(g => g.getAttribute('visibility') === 'hidden').length;
  const switched = [...runs, ...tables].reduce((sum, run) => sum + shown(run), 0);
  entry?.click();
  const first = [...data.runs, ...data.sweeps].flatMap(r => r.charts)[0];
  const result = {
    width: innerWidth, overflow: Math.max(0, document.documentElement.scrollWidth - innerWidth), smallest_text: Math.min(...sizes), contrast: contrasts[0], wide, zooms, switched,
    ticks: plots.map(p => p.querySelectorAll('.tick').length), axes: plots.map(p => p.querySelectorAll('.axis').length), legends: document.querySelectorAll('.legend button').length,
    areas: document.querySelectorAll('path.area').length, effects: document.querySelectorAll('.effects tbody tr').length,
    csv: first ? csvOf(first).trim().split('\n').map(line => line.split(',').length) : [],
    y_labels: [...document.querySelectorAll('.y-label')].map(t => t.textContent),
    charts: plots.length, lines: document.querySelectorAll('path.series').length, points: document.querySelectorAll('circle.point').length,
    tables: document.querySelectorAll('table').length, pictures: [...document.querySelectorAll('img.picture')].filter(i => i.complete && i.naturalWidth > 0).length, tips: tips.filter(t => t.length > 4).length, meridians, faults,
    requests: performance.getEntriesByType('resource').map(e => e.name), not_a_number: page.innerHTML.includes('NaN'),
    warnings: [...document.querySelectorAll('ul.warning li')].map(li => li.textContent),
  };
  return JSON.stringify(result);
}
selfTest();
