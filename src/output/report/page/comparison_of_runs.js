'use strict';
// Distances of the surfels of a run to the map of another run, in units of 0.1 mm (WriteReport()).
surfit.farFromMap = 65535;

// Quantile `share` of the known distances, mm; NaN without distances.
surfit.distanceQuantile = (map, share) => {
  if (!map.distance) return NaN;
  const near = map.distance.filter((tenths) => tenths !== surfit.farFromMap).sort();
  return near.length === 0 ? NaN : near[Math.floor(share * (near.length - 1))] / 10;
};

surfit.comparisonText = (run) => {
  if (!run.compared_with) return 'Not compared: fewer than three frames have timestamps of the other run.';
  const { map } = run;
  const far = map.distance.reduce((count, tenths) => count + (tenths === surfit.farFromMap), 0);
  const how = run.first_from_run.poses === 0 ? ''
    : `. The run is aligned by ${run.first_from_run.poses} poses with equal timestamps (RMS difference ${
      (1000 * run.first_from_run.rms_m).toFixed(1)} mm)`;
  return `Median distance of surfels: ${surfit.distanceQuantile(map, 0.5).toFixed(1)} mm to ${
    run.compared_with}, 90 % quantile: ${surfit.distanceQuantile(map, 0.9).toFixed(1)} mm; ${
    (100 * far / Math.max(map.shown, 1)).toFixed(1)} % have no surfel within 50 cm${how}.`;
};

// Transform from the world frame of a run to the world frame of the first run; identity if unknown.
surfit.firstFromRun = (run) => {
  const matrix = new THREE.Matrix4();
  if (!run.first_from_run) return matrix;
  const { rotation, translation } = run.first_from_run;
  return matrix.compose(new THREE.Vector3(...translation), new THREE.Quaternion(...rotation),
    new THREE.Vector3(1, 1, 1));
};
