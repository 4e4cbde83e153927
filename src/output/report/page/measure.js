'use strict';
// Measures the distance between two clicked points on surfaces.

// Intersection of a ray with the shown discs, in the world of the run; null if there is none. Discs are enlarged by
// 50 % to close the gaps between them.
surfit.pick = (map, ray, { cull, leastConfidence, isCropped }) => {
  const reach = 1.5 * map.max_radius * surfit.growth(map, map.shown) / 65535;
  const { origin: o, direction: d } = ray;
  let nearest = Infinity;
  for (let i = 0; i < map.shown; ++i) {
    const x = map.origin[0] + map.extent[0] * map.position[4 * i] / 65535 - o.x;
    const y = map.origin[1] + map.extent[1] * map.position[4 * i + 1] / 65535 - o.y;
    const z = map.origin[2] + map.extent[2] * map.position[4 * i + 2] / 65535 - o.z;
    const along = x * d.x + y * d.y + z * d.z;
    const radius = reach * map.radius[i];
    if (along <= 0 || along - radius > nearest) continue;
    if (x * x + y * y + z * z - along * along > radius * radius) continue;
    const [nx, ny, nz] = [map.normal[4 * i], map.normal[4 * i + 1], map.normal[4 * i + 2]];
    const facing = nx * d.x + ny * d.y + nz * d.z;
    if ((cull && facing > 0) || map.confidence[i] < leastConfidence || Math.abs(facing) < 10) continue;
    if (isCropped(x + o.x, y + o.y, z + o.z)) continue;
    const t = (nx * x + ny * y + nz * z) / facing;
    if (Math.abs(t - along) <= radius * 2 && t > 0 && t < nearest) nearest = t;
  }
  return nearest === Infinity ? null : ray.at(nearest, new THREE.Vector3());
};

surfit.Measure = class {
  constructor(button, says) {
    this.button = button;
    this.says = says;
    this.places = [];  // {cell, point}; two points are a measurement, a third point starts a new one
  }

  isOn() { return this.button.getAttribute('aria-pressed') === 'true'; }

  turn(on) {
    this.button.setAttribute('aria-pressed', String(on));
    if (!on) this.places = [];
    this.tell();
  }

  add(cell, point) {
    if (this.places.length === 2 || (this.places.length === 1 && this.places[0].cell !== cell)) this.places = [];
    this.places.push({ cell, point });
    this.tell();
  }

  metres() {
    return this.places.length === 2 ? this.places[0].point.distanceTo(this.places[1].point) : null;
  }

  tell() {
    const metres = this.metres();
    this.says.textContent = metres !== null ? `Measured: ${metres.toFixed(3)} m`
      : this.places.length === 1 ? 'Click the second point.'
        : this.isOn() ? 'Click a point on a surface.' : '';
  }
};
