'use strict';
// Estimated calibrations of the depth camera, during the run and at its end, and the course of a refinement.
surfit.cameraNumbers = ['fx', 'fy', 'cx', 'cy'];

surfit.withSigma = (value, sigma, digits) => (value === undefined ? ''
  : value.toFixed(digits) + (sigma === null || sigma === undefined ? '' : ` ± ${sigma.toFixed(digits)}`));

surfit.calibrationRow = (name, record) => {
  const sigmas = record.standard_deviations || {};
  return [name, String(record.keyframes),
    ...surfit.cameraNumbers.map((key) => surfit.withSigma(record.found[key], sigmas[key], 1)),
    surfit.withSigma(1000 * record.found.readout_s, sigmas.readout_s && 1000 * sigmas.readout_s, 1),
    record.termination + (record.as_given ? ', input calibration kept' : '')];
};

// Rows with the calibrations of a run of surfit_slam or surfit_refine.
surfit.calibrationRows = ({ summary }) => {
  const rows = (summary.calibrations || []).map(
    (record) => surfit.calibrationRow(`from frame ${record.frame + 1}`, record));
  if (summary.refinement) {
    const { rounds, seconds } = summary.refinement;
    rows.push(surfit.calibrationRow(`final refinement (${rounds} rounds, ${seconds.toFixed(1)} s)`, summary.refinement));
  }
  if (summary.calibration) {
    const { before, after, standard_deviations: sigmas } = summary.calibration;
    const record = { keyframes: summary.keyframes, termination: '', standard_deviations: null };
    rows.push(surfit.calibrationRow('before refinement', { ...record, found: before }),
      surfit.calibrationRow('refined', { ...record, found: after, standard_deviations: sigmas,
        termination: summary.termination, as_given: summary.calibration.kept }));
  }
  return rows;
};

surfit.calibrationNames = ['', 'keyframes', 'fx, px', 'fy, px', 'cx, px', 'cy, px', 'readout, ms', 'outcome'];

surfit.showRefinement = (runs) => {
  const parent = surfit.byId('refinement-columns');
  for (const run of runs) {
    const column = surfit.element('div', parent);
    surfit.element('h3', column, { textContent: run.label });
    const rows = surfit.calibrationRows(run);
    if (rows.length === 0) {
      surfit.say(column, 'The camera was neither calibrated nor refined.');
      continue;
    }
    surfit.addTable(surfit.element('div', column, { className: 'table figures' }), surfit.calibrationNames, rows);
    if (run.summary.calibration_warning) surfit.say(column, run.summary.calibration_warning);
    surfit.showRounds(run, column);
  }
};

// Residual between frames and surfels before the first round and after each round.
surfit.showRounds = (run, parent) => {
  const { rounds } = run.summary;
  if (!Array.isArray(rounds) || rounds.length === 0) return;
  const data = [rounds[0].before, ...rounds.map((round) => round.after)].map(
    (fit, x) => ({ x, y: 1000 * fit.rms_m }));
  surfit.addChart(parent, 'residual between frames and surfels', [
    surfit.line(run.label, surfit.runColor(0), data, { pointRadius: 3 })], {
    x: surfit.axis('round'), y: surfit.axis('RMS, mm') });
};
