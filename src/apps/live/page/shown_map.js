'use strict';
// Part of the map on this page: slots, most of which contain a surfel. Each answer of the server contains changes
// (LiveData::Map()). A round goes through all slots. The next round requests the changes since the start of this
// round.
surfit.headWords = 6;  // epoch, level, slots, version, next, count
surfit.bytesPerSurfel = 16;
surfit.metresPerRadius = 0.0005;
// Type and number of values per slot.
surfit.slotArrays = { position: [Float32Array, 3], normal: [Int8Array, 4], color: [Uint8Array, 4],
  radius: [Uint8Array, 1], confidence: [Uint8Array, 1], shade: [Uint8Array, 4] };

surfit.ShownMap = class {
  constructor() {
    this.geometry = new THREE.BufferGeometry();
    this.reserve(1024);
    this.forget();
  }

  // Grows all arrays to `slots` slots.
  reserve(slots) {
    for (const [name, [Type, items]] of Object.entries(surfit.slotArrays)) {
      const array = new Type(slots * items);
      if (this[name]) array.set(this[name]);
      this[name] = array;
    }
    this.geometry.dispose();  // frees the smaller buffers on the graphics card
    surfit.setDiscs(this.geometry, this);
    this.capacity = slots;
  }

  forget() {
    this.radius.fill(0);
    this.confidence.fill(0);
    Object.assign(this, { epoch: 0, level: 0, slots: 0, since: 0, slot: 0, begun: 0 });
  }

  // Parameters of the next request.
  query() {
    return `epoch=${this.epoch}&level=${this.level}&since=${this.since}&slot=${this.slot}`;
  }

  // Drops every second slot.
  halve() {
    const left = Math.ceil(this.slots / 2);
    for (const [name, [, items]] of Object.entries(surfit.slotArrays)) {
      for (let i = 1; i < left; ++i) this[name].copyWithin(items * i, items * 2 * i, items * (2 * i + 1));
    }
    this.radius.fill(0, left, this.slots);
    this.confidence.fill(0, left, this.slots);
    this.slots = left;
    ++this.level;
  }

  // Applies an answer. Returns true if the round continues.
  take(buffer, coloring) {
    const [epoch, level, slots, version, next, count] = new Uint32Array(buffer, 0, surfit.headWords);
    if (epoch !== this.epoch) {
      this.forget();
      this.epoch = epoch;
      this.level = level;
    }
    while (this.level < level) this.halve();
    if (slots > this.capacity) this.reserve(Math.max(slots, 2 * this.capacity));
    this.slots = slots;
    if (this.slot === 0) this.begun = version;
    const changed = new Uint32Array(buffer, 4 * surfit.headWords, count);
    const bytes = new DataView(buffer, 4 * (surfit.headWords + count));
    for (let i = 0; i < count; ++i) this.set(changed[i], bytes, surfit.bytesPerSurfel * i, coloring);
    this.slot = next;
    if (next === 0) this.since = this.begun;
    if (count > 0) this.renew();
    return next !== 0;
  }

  set(slot, bytes, at, coloring) {
    const low = bytes.getUint32(at, true), high = bytes.getUint32(at + 4, true);
    const middle = 1 << 20;
    this.position[3 * slot] = ((low & 0x1fffff) - middle) / 1000;
    this.position[3 * slot + 1] = (((low >>> 21) | ((high & 0x3ff) << 11)) - middle) / 1000;
    this.position[3 * slot + 2] = (((high >>> 10) & 0x1fffff) - middle) / 1000;
    for (let k = 0; k < 3; ++k) {
      this.normal[4 * slot + k] = bytes.getInt8(at + 8 + k);
      this.color[4 * slot + k] = bytes.getUint8(at + 11 + k);
    }
    this.radius[slot] = bytes.getUint8(at + 14);
    this.confidence[slot] = bytes.getUint8(at + 15);
    surfit.shadeSurfel(this, slot, coloring);
  }

  renew() {
    for (const attribute of Object.values(this.geometry.attributes)) attribute.needsUpdate = true;
    this.geometry.setDrawRange(0, this.slots);
  }

  recolor(coloring) {
    for (let slot = 0; slot < this.slots; ++slot) surfit.shadeSurfel(this, slot, coloring);
    this.renew();
  }

  count() { return this.radius.subarray(0, this.slots).filter((radius) => radius > 0).length; }

  // Positions of about `most` surfels.
  positions(most) {
    const step = Math.max(1, Math.floor(this.slots / most));
    const positions = [];
    for (let slot = 0; slot < this.slots; slot += step) {
      if (this.radius[slot] > 0) positions.push(new THREE.Vector3().fromArray(this.position, 3 * slot));
    }
    return positions;
  }
};

// The confidence is a WeightByte, which is logarithmic. The colours range from dust to confident surfels.
surfit.liveColorings = { ...surfit.colorings,
  confidence: surfit.scaledColoring((map, i) => map.confidence[i], [150, 220]) };
