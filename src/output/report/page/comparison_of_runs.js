'use strict';
// How far a run's surfels are from another run's map. WriteReport() has them in tenths of a millimetre.
surfit.farFromMap = 65535;

// In millimetres: of the surfels that have a distance, the share that is at most so far.
surfit.distanceQuantile = (map, share) => {
  if (!map.distance) return NaN;
  const near = map.distance.filter((tenths) => tenths !== surfit.farFromMap).sort();
  return near.length === 0 ? NaN : near[Math.floor(share * (near.length - 1))] / 10;
};

surfit.comparisonText = (run) => {
  if (!run.compared_with) return 'Not compared: no three frames have the times of the other run.';
  const { map } = run;
  const far = map.distance.reduce((count, tenths) => count + (tenths === surfit.farFromMap), 0);
  const how = run.first_from_run.poses === 0 ? ''
    : `, moved by ${run.first_from_run.poses} poses of equal times, which then differ by ${
      (1000 * run.first_from_run.rms_m).toFixed(1)} mm (RMS)`;
  return `Surfels are ${surfit.distanceQuantile(map, 0.5).toFixed(1)} mm from ${run.compared_with} in the median, ${
    surfit.distanceQuantile(map, 0.9).toFixed(1)} mm for nine of ten; ${
    (100 * far / Math.max(map.shown, 1)).toFixed(1)} % have nothing within 50 cm${how}.`;
};

// The transform from a run's world to that of the first run; the identity where it is not known.
surfit.firstFromRun = (run) => {
  const matrix = new THREE.Matrix4();
  if (!run.first_from_run) return matrix;
  const { rotation, translation } = run.first_from_run;
  return matrix.compose(new THREE.Vector3(...translation), new THREE.Quaternion(...rotation),
    new THREE.Vector3(1, 1, 1));
};
