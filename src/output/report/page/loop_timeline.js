'use strict';
// Loops over time: an arc between the two frames of each loop, above a band with the state of each frame.
surfit.timeline = { high: 170, band: 16, side: 10 };
surfit.stateColors = { tracked: '#7fa8d9', given: '#7fa8d9', first: '#20242a', degenerate: '#e0b400',
  frozen: '#9aa2ad', lost: '#d1495b', skipped: '#6b3fa0', relocalised: '#2e9e5b', new_map: '#e08a00' };
surfit.mostArcs = 2000;

surfit.svg = (tag, parent, attributes = {}) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  parent.append(element);
  return element;
};

surfit.loopText = (loop) => {
  const facts = [`frames ${loop.source} and ${loop.target}: ${surfit.reasonText(loop.reason)}`];
  if (loop.matches > 0) facts.push(`${loop.agreeing_features} of ${loop.matches} features agree`);
  if (loop.inlier_ratio > 0) {
    facts.push(`${(100 * loop.inlier_ratio).toFixed(0)} % inliers, RMSE ${(1000 * loop.rmse_m).toFixed(1)} mm`);
  }
  return facts.join(', ');
};

// Loops that match the filter: a kind, a reason, or all.
surfit.filteredLoops = (run) => {
  const filter = surfit.byId('loop-filter').value;
  return run.loops.filter((loop) => filter === 'all' || loop.kind === filter || loop.reason === filter);
};

// Groups of consecutive frames with equal state: [first, last, state].
surfit.stretches = ({ index, state }) => {
  const found = [];
  index.forEach((frame, i) => {
    if (i > 0 && state[i] === state[i - 1]) found[found.length - 1][1] = frame;
    else found.push([frame, frame, state[i]]);
  });
  return found;
};

surfit.drawBand = (svg, run, x, top) => {
  const { band } = surfit.timeline;
  for (const [first, last, state] of run.frames ? surfit.stretches(run.frames) : []) {
    const rect = surfit.svg('rect', svg, { x: x(first), y: top, height: band,
      width: Math.max(x(last + 1) - x(first), 1), fill: surfit.stateColors[state] || '#888888' });
    surfit.svg('title', rect).textContent = `${state}: frames ${first} to ${last}`;
  }
  for (const [frame] of run.poses.keyframes) {
    surfit.svg('line', svg, { x1: x(frame), x2: x(frame), y1: top - 4, y2: top, class: 'keyframe' });
  }
};

// Draws an arc whose height increases with its length.
surfit.drawArc = (svg, run, loop, x, base, longestPx) => {
  const [a, b] = [x(loop.target), x(loop.source)].sort((p, q) => p - q);
  const rise = (base - 6) * (0.15 + 0.85 * (b - a) / longestPx);
  const arc = surfit.svg('path', svg, { d: `M ${a} ${base} Q ${(a + b) / 2} ${base - 2 * rise} ${b} ${base}`,
    stroke: surfit.loopKinds[loop.kind].color, class: `arc ${loop.kind}` });
  surfit.svg('title', arc).textContent = surfit.loopText(loop);
  arc.addEventListener('click', (event) => {
    event.stopPropagation();
    surfit.selectLoop(run, loop);
  });
};

surfit.drawTimeline = (box, run) => {
  box.textContent = '';
  const { high, band, side } = surfit.timeline;
  const width = box.clientWidth;
  const [first, last] = surfit.frameRange(run);
  const x = (frame) => side + (width - 2 * side) * (frame - first) / Math.max(last + 1 - first, 1);
  const base = high - band - 28;
  const loops = surfit.filteredLoops(run).slice(0, surfit.mostArcs);
  const svg = surfit.svg('svg', box, { width, height: high, role: 'img', 'aria-label':
    `${run.label}: frames ${first} to ${last} and ${loops.length} loops between them` });
  const longestPx = Math.max(1, ...loops.map((loop) => Math.abs(x(loop.source) - x(loop.target))));
  for (const loop of [...loops].reverse()) surfit.drawArc(svg, run, loop, x, base - 4, longestPx);
  surfit.drawBand(svg, run, x, base);
  const step = surfit.niceStep((last - first) / Math.max(2, width / 90));
  for (let frame = Math.ceil(first / step) * step; frame <= last; frame += step) {
    surfit.svg('text', svg, { x: x(frame), y: high - 8, class: 'tick-text' }).textContent = frame;
  }
  svg.addEventListener('click', (event) => {
    const share = (event.clientX - svg.getBoundingClientRect().left - side) / (width - 2 * side);
    surfit.selectFrame(run, Math.round(Math.min(Math.max(first + share * (last + 1 - first), first), last)));
  });
};

// Smallest of 1, 2 and 5 times a power of ten that is at least `least`.
surfit.niceStep = (least) => {
  const power = 10 ** Math.floor(Math.log10(Math.max(least, 1)));
  return [1, 2, 5, 10].map((k) => k * power).find((step) => step >= least) || 1;
};

surfit.selectLoop = (run, loop) => {
  surfit.byId('loop-facts').textContent = surfit.loopText(loop);
  const pictures = surfit.byId('loop-pictures');
  pictures.textContent = '';
  for (const frame of [loop.source, loop.target]) surfit.addFramePictures(pictures, run, frame, 2);
  if (!surfit.mapView) return;
  if (loop.kind === 'refused' && !surfit.byId('show-refused').checked) surfit.byId('show-refused').click();
  surfit.mapView.select(run, [loop.source, loop.target]);
};

surfit.loopHeads = ['frames', 'result', 'consistent features', 'inliers', 'RMSE, mm'];
surfit.mostRows = 200;

surfit.loopCells = (run, loop) => {
  const button = surfit.element('button', null, { type: 'button', className: 'link',
    textContent: `${loop.source}, ${loop.target}` });
  button.addEventListener('click', () => surfit.selectLoop(run, loop));
  return [button, surfit.reasonText(loop.reason), `${loop.agreeing_features} of ${loop.matches}`,
    `${(100 * loop.inlier_ratio).toFixed(0)} %`, (1000 * loop.rmse_m).toFixed(1)];
};

surfit.showLoopTable = (runs) => {
  const parent = surfit.byId('loop-table');
  parent.textContent = '';
  for (const run of runs) {
    const loops = surfit.filteredLoops(run);
    if (loops.length === 0) continue;
    surfit.element('h3', parent, { textContent: run.label });
    const table = surfit.addTable(parent, surfit.loopHeads,
      loops.slice(0, surfit.mostRows).map((loop) => surfit.loopCells(run, loop)));
    loops.slice(0, surfit.mostRows).forEach((loop, i) => { table.tBodies[0].rows[i].className = loop.kind; });
    if (loops.length > surfit.mostRows) surfit.say(parent, `and ${loops.length - surfit.mostRows} more`);
  }
};

// One option per kind, and one per reason of rejected loops, ordered by frequency.
surfit.fillLoopFilter = (loops) => {
  const select = surfit.byId('loop-filter');
  const add = (value, text, { length }) => surfit.element('option', select, { value, textContent: `${text} (${length})` });
  const kinds = surfit.groupBy(loops, (loop) => loop.kind);
  for (const [kind, { name }] of Object.entries(surfit.loopKinds)) {
    if (kinds.has(kind) || kind === 'accepted') add(kind, name, kinds.get(kind) || []);
  }
  const reasons = [...surfit.groupBy(kinds.get('refused') || [], (loop) => loop.reason)];
  for (const [reason, refused] of reasons.sort((a, b) => b[1].length - a[1].length)) {
    add(reason, `rejected: ${surfit.reasonText(reason)}`, refused);
  }
  add('all', 'all', loops);
  if (!kinds.has('accepted')) select.value = 'all';
  select.parentElement.hidden = loops.length === 0;
};

surfit.showStateLegend = (parent, { frames }) => {
  if (!frames) return;
  const legend = surfit.say(parent, '', 'note state-legend');
  for (const [state, { length }] of surfit.groupBy(frames.state, (state) => state)) {
    const item = surfit.element('span', legend);
    surfit.element('i', item).style.background = surfit.stateColors[state];
    surfit.element('span', item, { textContent: `${state}: ${length}` });
  }
};

surfit.showLoops = (runs) => {
  const parent = surfit.byId('loop-timelines');
  surfit.fillLoopFilter(runs.flatMap((run) => run.loops));
  const boxes = runs.map((run) => {
    surfit.element('h3', parent, { textContent: run.label });
    const keyframes = `${run.poses.keyframes.length} keyframes (ticks); `;
    surfit.say(parent, keyframes + (run.loops.length > 0 ? `loop candidates: ${run.loops.length}.`
      : 'no loop candidates (surfit_slam searches for loops with --loop_closure).'));
    surfit.showStateLegend(parent, run);
    return surfit.element('div', parent, { className: 'timeline' });
  });
  const draw = () => {
    boxes.forEach((box, i) => surfit.drawTimeline(box, runs[i]));
    surfit.showLoopTable(runs);
  };
  surfit.on('loop-filter', 'change', draw);
  surfit.whenInSight(parent, () => new ResizeObserver(draw).observe(parent));  // also calls `draw` at the start
};
