'use strict';
surfit.headline = (run) => {
  const s = run.summary;
  if (!run.frames) return `${s.poses} poses refined with ${s.keyframes} keyframes, ${s.map_points} surfels`;
  const ate = s.ate_rmse_m === null ? 'ATE unknown' : `ATE ${(1000 * s.ate_rmse_m).toFixed(2)} mm`;
  return `${s.frames_total} frames, ${s.frames_tracked} tracked, ${ate}, ${s.map_points} surfels, ${
    s.frame_ms.median.toFixed(1)} ms per frame`;
};

(() => {
  surfit.connectTheme();
  const runs = surfit.readRuns();
  surfit.runs = runs;
  document.title = `Surfit: ${runs.map((run) => run.label).join(', ')}`;
  document.documentElement.style.setProperty('--columns', runs.length);
  surfit.byId('headline').textContent = runs.length === 1 ? surfit.headline(runs[0])
    : `${runs.length} runs side by side`;
  surfit.showMapLabels(runs);
  surfit.mapView = surfit.withWebGl(surfit.byId('map-view'), () => new surfit.MapView(runs));
  surfit.showFramePanel(runs);
  surfit.showLoops(runs);
  surfit.showTrajectories(runs);
  surfit.showFrames(runs);
  surfit.showViews(runs);
  surfit.showRefinement(runs);
  surfit.addRunTable(surfit.byId('summary-table'), runs, ({ summary: { options, ...rest } }) => rest);
  surfit.addRunTable(surfit.byId('options-table'), runs, (run) => run.summary.options);
  surfit.byId('differing-label').hidden = runs.length < 2;
  document.documentElement.dataset.readyMs = performance.now().toFixed(0);
})();
