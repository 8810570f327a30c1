// Test of the page of a view, evaluated in it by the browser: it reads the top-level names of src/analysis/view/view.js.
(async () => {
  const until = async condition => { while (!condition()) await new Promise(done => setTimeout(done, 20)); };
  await until(() => view.mesh.state.shown > 0 && parts.run && parts.run.summary);
  const m = view.mesh, canvas = m.canvas;
  const print = () => {
    m.paint();
    const copy = document.createElement('canvas');
    copy.width = canvas.width; copy.height = canvas.height;
    const g = copy.getContext('2d');
    g.drawImage(canvas, 0, 0);
    return g.getImageData(0, 0, copy.width, copy.height).data.reduce((sum, v) => (sum * 31 + v) % 2147483647, 0);
  };
  const frames = parts.frames.times.length, byFrame = [], byField = [], meshes = new Set();
  for (let i = 0; i < frames; i++) { await m.show(i); byFrame.push(print()); meshes.add(store.mesh); }
  for (let i = 0; i < parts.frames.fields.length; i++) { await m.setField(i); byField.push(print()); }
  await m.setField(0);
  m.paint();
  // A click on the middle of the body: the element there is searched for independently, by the nearest centre.
  const box = canvas.getBoundingClientRect(), at = [0.4 * box.width, 0.45 * box.height];
  for (const type of ['pointerdown', 'pointerup']) canvas.dispatchEvent(new PointerEvent(type, { button: 0, clientX: box.left + at[0], clientY: box.top + at[1] }));
  await until(() => view.chosen().values.length === frames && document.querySelectorAll('.facts dd').length > 0);
  const shape = store.get(m.state.frame, -1), chosen = view.chosen().choice.cell, { corners, cells, elements } = store.mesh;
  const centre = c => [0, 1, 2, 3].map(i => corners[4 * c + i]).reduce(([r, z], p) => [r + shape.positions[2 * p] / 4, z + shape.positions[2 * p + 1] / 4], [0, 0]);
  const [r, z] = m.position(...at), distance = c => Math.hypot(centre(c)[0] - Math.abs(r), centre(c)[1] - z);
  let nearest = 0;
  for (let c = 0; c < cells; c++) if (distance(c) < distance(nearest)) nearest = c;
  // The same element in the first frame, whose mesh may not have it, and in the last one again.
  const selected = [];
  await m.show(0);
  await until(() => view.chosen().frame === 0);
  selected.push(m.state.selected);
  const inFirst = [...document.querySelectorAll('p.soft')].map(p => p.textContent).find(text => text.startsWith('The mesh of frame 1 ')) || '';
  await m.show(frames - 1);
  selected.push(m.state.selected, chosen);
  const heading = [...document.querySelectorAll('h3')].map(h => h.textContent).find(text => text.startsWith('element '));
  return JSON.stringify({
    kind: m.drawing.kind, faults, frames, different_frames: new Set(byFrame).size, fields: byField.length, different_fields: new Set(byField).size,
    badge: document.querySelector('.badge').textContent, trace: view.chosen().values.filter(Number.isFinite).length, element: heading,
    meshes: meshes.size, missing: view.chosen().missing.length, in_first_frame: inFirst, selected,
    reason: [...document.querySelectorAll('p.soft')].map(p => p.textContent).find(text => text.includes(' is not in frame')) || '',
    picked: elements[chosen], expected: elements[nearest], state: document.querySelectorAll('.facts dd').length,
    ledger: [...document.querySelectorAll('h3')].some(h => h.textContent.startsWith('Ledger')), charts: [...view.charts.keys()],
    overflow: Math.max(0, document.documentElement.scrollWidth - innerWidth),
  });
})();
