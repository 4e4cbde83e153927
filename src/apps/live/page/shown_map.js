'use strict';
// The part of the map that the server sends: slots, most of which hold a surfel. Every answer of the server
// brings changes (ShownRun::Map()): a round goes through all slots, and the next one asks for what has changed
// since this one began.
surfit.headWords = 6;  // epoch, level, slots, version, next, count
surfit.bytesPerSurfel = 16;
surfit.metresPerRadius = 0.0005;

surfit.ShownMap = class {
  constructor() {
    this.geometry = new THREE.BufferGeometry();
    this.reserve(1024);
    this.forget();
  }

  // All arrays with place for so many slots.
  reserve(slots) {
    const grown = (old, type, items) => {
      const array = new type(slots * items);
      if (old) array.set(old);
      return array;
    };
    this.position = grown(this.position, Float32Array, 3);
    this.normal = grown(this.normal, Int8Array, 4);
    this.color = grown(this.color, Uint8Array, 4);
    this.radius = grown(this.radius, Uint8Array, 1);
    this.confidence = grown(this.confidence, Uint8Array, 1);
    this.shade = grown(this.shade, Uint8Array, 4);
    this.geometry.dispose();  // the graphics card forgets the smaller ones
    const attribute = (name, items, normalised) =>
      this.geometry.setAttribute(name, new THREE.BufferAttribute(this[name], items, normalised));
    attribute('position', 3, false);
    attribute('normal', 4, true);
    attribute('radius', 1, true);
    attribute('confidence', 1, false);
    attribute('shade', 4, true);
    this.capacity = slots;
  }

  forget() {
    this.radius.fill(0);
    this.confidence.fill(0);
    Object.assign(this, { epoch: 0, level: 0, slots: 0, since: 0, slot: 0, begun: 0 });
  }

  // What to ask the server for.
  query() {
    return `epoch=${this.epoch}&level=${this.level}&since=${this.since}&slot=${this.slot}`;
  }

  // Keeps every other slot.
  halve() {
    const left = Math.ceil(this.slots / 2);
    const move = (array, items) => {
      for (let i = 1; i < left; ++i) array.copyWithin(items * i, items * 2 * i, items * (2 * i + 1));
    };
    move(this.position, 3);
    for (const name of ['normal', 'color', 'shade']) move(this[name], 4);
    for (const name of ['radius', 'confidence']) {
      move(this[name], 1);
      this[name].fill(0, left, this.slots);
    }
    this.slots = left;
    ++this.level;
  }

  // Takes an answer; returns whether the round goes on.
  take(buffer, colorOf) {
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
    for (let i = 0; i < count; ++i) this.set(changed[i], bytes, surfit.bytesPerSurfel * i, colorOf);
    this.slot = next;
    if (next === 0) this.since = this.begun;
    if (count > 0) this.renew();
    return next !== 0;
  }

  set(slot, bytes, at, colorOf) {
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
    colorOf(this, slot);
  }

  renew() {
    for (const attribute of Object.values(this.geometry.attributes)) attribute.needsUpdate = true;
    this.geometry.setDrawRange(0, this.slots);
  }

  recolor(colorOf) {
    for (let slot = 0; slot < this.slots; ++slot) colorOf(this, slot);
    this.renew();
  }

  count() {
    let count = 0;
    for (let slot = 0; slot < this.slots; ++slot) count += this.radius[slot] > 0 ? 1 : 0;
    return count;
  }

  // Places of about `most` surfels.
  places(most) {
    const step = Math.max(1, Math.floor(this.slots / most));
    const places = [];
    for (let slot = 0; slot < this.slots; slot += step) {
      if (this.radius[slot] > 0) places.push(new THREE.Vector3().fromArray(this.position, 3 * slot));
    }
    return places;
  }
};

// What each surfel's shade is made of.
surfit.colorings = {
  color: (map, i) => map.shade.set(map.color.subarray(4 * i, 4 * i + 3), 4 * i),
  normal: (map, i) => {
    for (let k = 0; k < 3; ++k) map.shade[4 * i + k] = 127.5 + map.normal[4 * i + k];
  },
  // A WeightByte is logarithmic: from dust on, dark to light.
  confidence: (map, i) => {
    const share = Math.min(Math.max((map.confidence[i] - 150) / 70, 0), 1);
    map.shade[4 * i] = 40 + 210 * share;
    map.shade[4 * i + 1] = 60 + 150 * share;
    map.shade[4 * i + 2] = 120 - 60 * share;
  },
};
