'use strict';
// Charts over frames. Comparable values have one chart for all runs, stacked values have one chart per run.
surfit.states = ['skipped', 'lost', 'frozen', 'degenerate', 'tracked', 'given', 'first', 'relocalised', 'new_map'];
surfit.stages = ['read', 'preprocess', 'predict', 'track', 'fuse'];

// Number of surfels after each frame.
surfit.mapSizes = (frames) => {
  let size = 0;
  return frames.added.map((added, i) => (size += added - frames.removed[i]));
};

// Values of the registration: NaN for frames without registration, empty for runs of older releases.
surfit.ofRegistration = (frames, column, unit = 1) => (frames[column] || []).map(
  (value, i) => (frames.termination[i] ? unit * value : NaN));

// [title, unit, values of each frame]
surfit.sharedCharts = [
  ['inlier ratio', '', (frames) => surfit.ofRegistration(frames, 'inlier_ratio')],
  ['inliers', 'points', (frames) => surfit.ofRegistration(frames, 'inliers')],
  ['RMSE of registration', 'mm', (frames) => surfit.ofRegistration(frames, 'rmse_m', 1000)],
  ['moving objects, share of the view', '%',
    (frames) => surfit.ofRegistration(frames, 'moving_ratio', 100)],
  ['surfels in the map', '', surfit.mapSizes],
  ['time per frame', 'ms', (frames) => frames.frame_ms],
];

surfit.stateAxis = surfit.axis('', { min: -0.5, max: surfit.states.length - 0.5,
  afterBuildTicks: (axis) => { axis.ticks = surfit.states.map((_, value) => ({ value })); },
  ticks: { callback: (value) => surfit.states[value] } });

surfit.showRunCharts = ({ label, frames }, parent) => {
  const column = surfit.element('div', parent);
  surfit.element('h3', column, { textContent: label });
  const addChart = (title, names, ending, y, more) => surfit.addChart(column, title,
    names.map((name, i) => surfit.line(name, surfit.runColor(i),
      surfit.pairs(frames.index, frames[name + ending]), more)), { x: surfit.axis('frame'), y });
  addChart('time by stage (decoding runs in the background)', surfit.stages, '_ms',
    surfit.axis('ms', { stacked: true, beginAtZero: true }), { fill: true, borderWidth: 0 });
  addChart('surfels merged, added and removed', ['merged', 'added', 'removed'], '',
    surfit.axis('surfels', { beginAtZero: true }));
};

surfit.showFrames = (allRuns) => {
  const runs = allRuns.filter((run) => run.frames);
  surfit.byId('frames').hidden = runs.length === 0;
  const addChart = (title, valuesOf, y, lines, plugins) => surfit.addChart(surfit.byId('shared-charts'), title,
    surfit.runLines(runs, ({ frames }) => surfit.pairs(frames.index, valuesOf(frames)), lines),
    { x: surfit.axis('frame'), y, plugins });
  for (const [title, unit, valuesOf] of surfit.sharedCharts) {
    addChart(title, valuesOf, surfit.axis(unit, { beginAtZero: true }));
  }
  addChart('tracking state', (frames) => frames.state.map((state) => surfit.states.indexOf(state)),
    surfit.stateAxis, { stepped: true, pointRadius: 1 },
    { tooltip: { callbacks: { label: (item) => surfit.states[item.parsed.y] } } });
  for (const run of runs) surfit.showRunCharts(run, surfit.byId('run-charts'));
};
