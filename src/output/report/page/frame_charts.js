'use strict';
// Figures of every frame: one chart for all runs where they compare, one per run where values are stacked.
surfit.states = ['skipped', 'lost', 'frozen', 'degenerate', 'tracked', 'given', 'first', 'relocalised', 'new_map'];
surfit.stages = ['decode', 'preprocess', 'predict', 'track', 'fuse'];

// Sizes of the map after each frame.
surfit.mapSizes = (frames) => {
  let size = 0;
  return frames.added.map((added, i) => (size += added - frames.removed[i]));
};

// A figure of registration; NaN for frames that were not registered, nothing where the run is older than it.
surfit.ofRegistration = (frames, column, unit = 1) => (frames[column] || []).map(
  (value, i) => (frames.termination[i] ? unit * value : NaN));

surfit.sharedCharts = [
  { title: 'inlier share', unit: '',
    of: (frames) => surfit.ofRegistration(frames, 'inlier_share') },
  { title: 'inliers', unit: 'points', of: (frames) => surfit.ofRegistration(frames, 'inliers') },
  { title: 'RMSE of registration', unit: 'mm',
    of: (frames) => surfit.ofRegistration(frames, 'rmse_m', 1000) },
  { title: 'share of the view that moves by itself', unit: '%',
    of: (frames) => surfit.ofRegistration(frames, 'moving_share', 100) },
  { title: 'surfels in the map', unit: '', of: surfit.mapSizes },
  { title: 'time per frame', unit: 'ms', of: (frames) => frames.frame_ms },
];

surfit.showStates = (runs, parent) => surfit.addChart(parent, 'state of tracking',
  runs.map((run, i) => surfit.line(run.label, surfit.runColor(i),
    surfit.pairs(run.frames.index, run.frames.state.map((state) => surfit.states.indexOf(state))),
    { stepped: true, pointRadius: 1 })), {
    x: surfit.axis('frame'),
    y: surfit.axis('', { min: -0.5, max: surfit.states.length - 0.5,
      afterBuildTicks: (axis) => { axis.ticks = surfit.states.map((_, value) => ({ value })); },
      ticks: { callback: (value) => surfit.states[value] } }),
    plugins: { tooltip: { callbacks: { label: (item) => surfit.states[item.parsed.y] } } } });

surfit.showRunCharts = (run, parent) => {
  const { frames } = run;
  const column = surfit.element('div', parent);
  surfit.element('h3', column, { textContent: run.label });
  const x = surfit.axis('frame');
  surfit.addChart(column, 'time by stage (decode runs ahead in the background)',
    surfit.stages.map((stage, i) => surfit.line(stage, surfit.runColor(i),
      surfit.pairs(frames.index, frames[`${stage}_ms`]), { fill: true, borderWidth: 0 })),
    { x, y: surfit.axis('ms', { stacked: true, beginAtZero: true }) });
  surfit.addChart(column, 'surfels merged, added and removed',
    ['merged', 'added', 'removed'].map((name, i) => surfit.line(name, surfit.runColor(i),
      surfit.pairs(frames.index, frames[name]))),
    { x, y: surfit.axis('surfels', { beginAtZero: true }) });
};

surfit.showFrames = (allRuns) => {
  const runs = allRuns.filter((run) => run.frames);
  surfit.byId('frames').hidden = runs.length === 0;
  const shared = surfit.byId('shared-charts');
  for (const { title, unit, of } of surfit.sharedCharts) {
    surfit.addChart(shared, title, runs.map((run, i) => surfit.line(run.label, surfit.runColor(i),
      surfit.pairs(run.frames.index, of(run.frames)))),
    { x: surfit.axis('frame'), y: surfit.axis(unit, { beginAtZero: true }) });
  }
  surfit.showStates(runs, shared);
  for (const run of runs) surfit.showRunCharts(run, surfit.byId('run-charts'));
};
