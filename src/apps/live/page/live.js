'use strict';
// Asks the server for what is new, each thing by a loop of its own: who gets it slowly asks seldom. Nothing is
// asked for while nobody sees the page.
surfit.retryMs = 1000;
surfit.mapGapMs = 150;
surfit.pictureGapMs = 60;
surfit.stateGapMs = 60;

// The bits of what is to be kept ready for the page (enum Shown).
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
    this.waiting = [];  // for a new state
    this.seen = {};  // the numbers of what has been taken
    this.last = {};  // the pictures that the run ended with
  }

  async get(path) {
    const answer = await fetch(path, { cache: 'no-store' });
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return answer;
  }

  // Calls `turn` again and again, and after failures later.
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
      this.panel.showLink(isOver ? 'the run is over; this is what it came to' : 'no connection', !isOver);
      throw error;
    }
    this.panel.showLink('');
    this.panel.showState(this.state);
    if (this.scene) this.scene.setState(this.state);
    for (const done of this.waiting.splice(0)) done();
    await surfit.sleep(surfit.stateGapMs);
  }

  // Waits for a thing that is newer than the last one that was taken of this name, and returns its number.
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
    this.panel.showPathLength(this.scene.places);
    this.seen.path = number;
  }

  // Frame and model of one moment, which have one number; where newer ones have come meanwhile, these. In the end
  // the model by colours and normals, as nobody can be asked for it later.
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
    if (window.confirm('Stop the run? What it has so far is written.')) surfit.post('stop');
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

// The buttons with keys.
surfit.buttonKeys = { ' ': 'pause', s: 'step', n: 'normals', f: 'follow', r: 'whole' };

(() => {
  const scene = surfit.withWebGl(surfit.byId('map'), () => new surfit.LiveScene(surfit.byId('map-canvas')));
  surfit.live = new surfit.Live(scene, new surfit.Panel());
  surfit.connectButtons(surfit.live, scene);
  surfit.connectKeys(document, scene, Object.fromEntries(
    Object.entries(surfit.buttonKeys).map(([key, id]) => [key, () => surfit.byId(id).click()])));
  surfit.live.start();
})();
