'use strict';
// Requests new data from the server. Each kind of data has its own loop, so slow connections send fewer requests.
// Hidden pages send no requests.
surfit.retryMs = 1000;
surfit.mapGapMs = 150;
surfit.pictureGapMs = 60;
surfit.stateGapMs = 60;

// Bits of the data that the page requests (enum Shown).
surfit.shownBits = { map: 2, path: 4, frame: 8, model: 16, normals: 32 };

surfit.sleep = (ms) => new Promise((done) => { setTimeout(done, ms); });

surfit.modelName = () => (surfit.byId('normals').checked ? 'normals' : 'model');

surfit.whenSeen = async () => {
  while (document.hidden) {
    await new Promise((done) => { document.addEventListener('visibilitychange', done, { once: true }); });
  }
};

surfit.Live = class {
  constructor(scene, panel) {
    this.scene = scene;
    this.panel = panel;
    this.state = null;
    this.waiting = [];  // callbacks for the next state
    this.seen = {};  // numbers of received data
    this.last = {};  // pictures of the final state
  }

  async get(path) {
    const answer = await fetch(path, { cache: 'no-store' });
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return answer;
  }

  // Calls `turn` repeatedly, with a delay after failures.
  async repeat(turn) {
    for (;;) {
      await surfit.whenSeen();
      try {
        await turn();
      } catch (error) {
        await surfit.sleep(surfit.retryMs);
      }
    }
  }

  wants() {
    const names = [surfit.modelName(), 'frame', ...(this.scene ? ['map', 'path'] : [])];
    return names.reduce((bits, name) => bits | surfit.shownBits[name], 0);
  }

  nextState() {
    return new Promise((done) => { this.waiting.push(done); });
  }

  async takeState() {
    try {
      const answer = await this.get(`state?after=${this.state ? this.state.number : 0}&want=${this.wants()}`);
      this.state = await answer.json();
    } catch (error) {
      const isOver = this.state && this.state.done;
      this.panel.showLink(isOver ? 'the run is over; this is the result' : 'no connection', !isOver);
      throw error;
    }
    this.panel.showLink('');
    this.panel.showState(this.state);
    if (this.scene) this.scene.setState(this.state);
    for (const done of this.waiting.splice(0)) done();
    await surfit.sleep(surfit.stateGapMs);
  }

  // Waits until the server has newer data of this name, and returns its number.
  async newer(name) {
    while (!this.state || this.state.numbers[name] <= (this.seen[name] || 0)) await this.nextState();
    return this.state.numbers[name];
  }

  async takeMap() {
    const number = await this.newer('map');
    for (let goesOn = true; goesOn;) {
      const answer = await this.get(`map?${this.scene.map.query()}`);
      goesOn = this.scene.takeMap(await answer.arrayBuffer());
    }
    this.seen.map = number;
    await surfit.sleep(surfit.mapGapMs);
  }

  async takePath() {
    const number = await this.newer('path');
    this.scene.setPath(await (await this.get('path')).json());
    this.panel.showPathLength(this.scene.positions);
    this.seen.path = number;
  }

  // Loads the frame and model pictures with the same number, which belong to the same frame. Outdated pictures are
  // skipped. After the run, loads colours and normals of the model, because the server ends soon.
  async takePictures() {
    const name = surfit.modelName();
    const { numbers = {}, done = false } = this.state || {};
    const number = numbers.frame;
    const isLast = done && !this.last.model;
    const isNew = number > (this.seen.pictures || 0) || isLast;
    if (!number || number !== numbers[name] || !isNew) return this.nextState();
    const names = isLast ? ['frame', 'model', 'normals'] : ['frame', name];
    const answers = await Promise.all(names.map((of) => this.get(`${of}.jpg?number=${number}`)));
    if (answers.some((answer) => answer.status === 204)) return this.nextState();
    const blobs = await Promise.all(answers.map((answer) => answer.blob()));
    if (isLast) [, this.last.model, this.last.normals] = blobs;
    await this.panel.showPictures(['frame-picture', 'model-picture'], [blobs[0], blobs[names.indexOf(name)]]);
    this.seen.pictures = number;
    return surfit.sleep(surfit.pictureGapMs);
  }

  changeModel() {
    this.seen.pictures = 0;
    const last = this.last[surfit.modelName()];
    if (last) this.panel.showPictures(['model-picture'], [last]);
  }

  start() {
    this.repeat(() => this.takeState());
    if (this.scene) {
      this.repeat(() => this.takeMap());
      this.repeat(() => this.takePath());
    }
    this.repeat(() => this.takePictures());
    surfit.on('normals', 'change', () => this.changeModel());
  }
};

surfit.post = (name) => fetch(name, { method: 'POST' }).catch(() => {});

surfit.connectButtons = (live, scene) => {
  surfit.on('pause', 'click', () => surfit.post(live.state && live.state.paused ? 'go_on' : 'pause'));
  surfit.on('step', 'click', () => surfit.post('step'));
  surfit.on('stop', 'click', () => {
    if (window.confirm('Stop the run? The results so far are written.')) surfit.post('stop');
  });
  if (!scene) return;
  const follow = (on) => {
    scene.follows = on;
    if (on) scene.lookFromCamera();
    surfit.byId('follow').setAttribute('aria-pressed', String(on));
  };
  surfit.on('follow', 'click', () => follow(!scene.follows));
  surfit.on('whole', 'click', () => {
    follow(false);
    scene.showWhole();
  });
  surfit.on('colors', 'change', ({ value }) => scene.setColors(value));
};

// Keys of the buttons.
surfit.buttonKeys = { ' ': 'pause', s: 'step', n: 'normals', f: 'follow', r: 'whole' };

(() => {
  const scene = surfit.withWebGl(surfit.byId('map'), () => new surfit.LiveScene(surfit.byId('map-canvas')));
  surfit.live = new surfit.Live(scene, new surfit.Panel());
  surfit.connectButtons(surfit.live, scene);
  surfit.connectKeys(document, scene, Object.fromEntries(
    Object.entries(surfit.buttonKeys).map(([key, id]) => [key, () => surfit.byId(id).click()])));
  surfit.live.start();
})();
