'use strict';
// Charts of the paths from above and of the position error.

// Unit vectors to the right of the mean viewing direction, along it, and up.
surfit.floorDirections = (run) => {
  const up = surfit.upOfRun(run.poses), ahead = surfit.level(surfit.forwardOf(run.poses.poses), up);
  return [new THREE.Vector3().crossVectors(ahead, up), ahead, up];
};

// Sets the same scale on both axes. Call after the layout of the chart.
surfit.equalAspect = (chart) => {
  const points = chart.data.datasets.flatMap((set) => set.data);
  const spans = ['x', 'y'].map((k) => surfit.range(points.map((p) => p[k])));
  const { width, height } = chart.chartArea;
  const metresPerPixel = 1.08 * Math.max((spans[0][1] - spans[0][0]) / width,
    (spans[1][1] - spans[1][0]) / height, 1e-6);
  [width, height].forEach((pixels, k) => {
    const middle = (spans[k][0] + spans[k][1]) / 2;
    const scale = chart.options.scales['xy'[k]];
    scale.min = middle - metresPerPixel * pixels / 2;
    scale.max = middle + metresPerPixel * pixels / 2;
  });
  chart.update('none');
};

// Tables of the pieces of runs with more than one piece.
surfit.showPieces = (runs, parent) => {
  for (const { label, summary } of runs) {
    if (!summary.pieces || summary.pieces.length < 2) continue;
    surfit.say(parent, `${label} has ${summary.pieces.length} pieces. No loop closure connects them, so only poses of `
      + 'one piece are comparable. The charts show the largest piece.');
    surfit.addTable(surfit.element('div', parent, { className: 'table pieces' }),
      ['first frame', 'last frame', 'frames with a pose', 'ATE, mm'],
      summary.pieces.map((piece) => [piece.first_frame, piece.last_frame, piece.frames,
        piece.ate_rmse_m === null ? 'unknown' : (1000 * piece.ate_rmse_m).toFixed(2)].map(String)));
  }
};

// Poses of the largest piece.
surfit.comparablePoses = ({ poses, largest_piece: frames }) => {
  const shown = new Set(frames || []);
  return frames ? poses.filter(([frame]) => shown.has(frame)) : poses;
};

surfit.showTrajectories = (runs) => {
  const parent = surfit.byId('trajectory-charts');
  surfit.showPieces(runs, parent);
  const [right, ahead] = surfit.floorDirections(runs[0]);
  const onFloor = (run, points) => points.map((point) => point.applyMatrix4(surfit.firstFromRun(run))).map(
    (p) => ({ x: right.dot(p), y: ahead.dot(p) }));
  const errors = runs.flatMap((run) => [...run.errors.values()]);
  const most = surfit.range(errors)[1];
  const datasets = runs.flatMap((run, i) => {
    const { truth } = run.poses;
    const poses = surfit.comparablePoses(run.poses);
    const colors = run.errors.size === 0 ? {} : { pointRadius: 2, pointBorderWidth: 0,
      pointBackgroundColor: poses.map(([frame]) => surfit.cssColor(
        surfit.scaleColor(run.errors.get(frame) || 0, 0, most))) };
    const estimate = surfit.line(`estimate: ${run.label}`, surfit.runColor(i),
      onFloor(run, poses.map(surfit.positionOf)), colors);
    return truth.length === 0 ? [estimate] : [estimate, surfit.line(`ground truth: ${run.label}`, '#ff8c1a',
      onFloor(run, truth.map((row) => new THREE.Vector3(...row.slice(1, 4)))), { borderDash: [5, 3] })];
  });
  surfit.say(parent, errors.length === 0 ? 'No ground truth: errors are unknown.'
    : `Colours show the position error from 0 (dark) to ${
      (1000 * most).toFixed(1)} mm (bright). Each ground truth is aligned to its run as for the ATE.`);
  surfit.addChart(parent, 'from above', datasets, {
    x: surfit.axis('right, m'), y: surfit.axis('ahead, m'), className: 'chart tall', zoomMode: 'xy',
    plugins: { tooltip: { enabled: false } } }, (chart) => {
    // The observer also calls once at the start.
    new ResizeObserver(() => surfit.equalAspect(chart)).observe(chart.canvas.parentElement);
  });
  if (errors.length === 0) return;
  surfit.addChart(parent, 'position error',
    surfit.runLines(runs, (run) => [...run.errors].map(([x, error]) => ({ x, y: 1000 * error }))),
    { x: surfit.axis('frame'), y: surfit.axis('mm', { beginAtZero: true }) });
};
