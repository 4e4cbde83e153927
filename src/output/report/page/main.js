'use strict';
surfit.headline = (run) => {
  const s = run.summary;
  if (!run.frames) return `${s.poses} poses refined by ${s.keyframes} keyframes, ${s.map_points} surfels`;
  const ate = s.ate_rmse_m === null ? 'ATE unknown' : `ATE ${(1000 * s.ate_rmse_m).toFixed(2)} mm`;
  return `${s.frames_total} frames, ${s.frames_tracked} tracked, ${ate}, ${s.map_points} surfels, ${
    s.frame_ms.median.toFixed(1)} ms a frame`;
};

// The rest of the page works without WebGL.
surfit.showMap = (runs) => {
  surfit.showMapLabels(runs);
  try {
    return new surfit.MapView(runs);
  } catch (error) {
    surfit.element('p', surfit.byId('map-view'), { className: 'failed',
      textContent: `No 3D view: this browser gives no WebGL (${error.message}).` });
    return null;
  }
};

(() => {
  surfit.connectTheme();
  const runs = surfit.readRuns();
  surfit.runs = runs;
  document.title = `Surfit: ${runs.map((run) => run.label).join(', ')}`;
  document.documentElement.style.setProperty('--columns', runs.length);
  surfit.byId('headline').textContent = runs.length === 1 ? surfit.headline(runs[0])
    : `${runs.length} runs side by side`;
  surfit.mapView = surfit.showMap(runs);
  surfit.showFramePanel(runs);
  surfit.showLoops(runs);
  surfit.showTrajectories(runs);
  surfit.showFrames(runs);
  surfit.byId('zoom-hint').hidden = !window.ChartZoom;
  surfit.showViews(runs);
  surfit.showRefinement(runs);
  surfit.showTables(runs);
  document.documentElement.dataset.readyMs = performance.now().toFixed(0);
})();
