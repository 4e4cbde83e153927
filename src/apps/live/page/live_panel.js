'use strict';
// Texts and pictures of the page.
surfit.adviceMs = 1500;  // minimum display time of advice

surfit.pillOfState = { lost: 'bad', degenerate: 'warn', relocalised: 'warn', new_map: 'warn' };

surfit.duration = (seconds) => {
  const two = (number) => String(Math.floor(number)).padStart(2, '0');
  const minutes = `${Math.floor(seconds / 60) % 60}`;
  return seconds < 3600 ? `${minutes}:${two(seconds % 60)}`
    : `${Math.floor(seconds / 3600)}:${two(seconds / 60 % 60)}:${two(seconds % 60)}`;
};

surfit.Panel = class {
  constructor() {
    this.advice = new Map();  // kind: { text, until }
  }

  showState(state) {
    const pill = surfit.byId('frame-state');
    const name = state.done ? 'done' : state.paused ? 'paused' : state.at_result ? 'finishing' : state.frame_state;
    pill.textContent = name;
    pill.className = `pill ${state.done || state.paused || state.at_result ? 'waiting'
      : surfit.pillOfState[state.frame_state] || ''}`;
    const set = (id, text) => { surfit.byId(id).textContent = text; };
    set('fps', state.frames_done > 0 ? `${state.frames_per_second.toFixed(1)} fps` : '');
    set('status', state.at_result || state.done ? state.status : '');
    const total = state.frames_total;
    set('frames', total < 0 ? state.frames_done : `${state.frames_done} of ${total}`);
    surfit.byId('progress-done').style.width = total > 0 ? `${100 * state.frames_done / total}%` : '0';
    set('elapsed', surfit.duration(state.elapsed_s));
    set('surfels', state.map_points.toLocaleString('en'));
    set('shown', state.shown.toLocaleString('en'));
    set('loops', state.last_loop ? `${state.loops} (${state.last_loop.join(' and ')})` : state.loops);
    set('pause', state.paused ? 'resume' : 'pause');
    const isOver = state.done || state.at_result;
    for (const id of ['pause', 'step']) surfit.byId(id).disabled = isOver;
    surfit.byId('stop').disabled = state.done;
    this.showAdvice(isOver ? [] : state.advice);
  }

  showPathLength(positions) {
    let metres = 0;
    for (let i = 1; i < positions.length; ++i) metres += positions[i].distanceTo(positions[i - 1]);
    surfit.byId('path-length').textContent = `${metres.toFixed(2)} m`;
  }

  // Shows each advice for at least surfit.adviceMs.
  showAdvice(advice) {
    const now = performance.now();
    for (const { kind, text } of advice) this.advice.set(kind, { text, until: now + surfit.adviceMs });
    for (const [kind, { until }] of this.advice) if (until < now) this.advice.delete(kind);
    const box = surfit.byId('advice');
    const shown = [...this.advice].map(([kind, { text }]) => `${kind}: ${text}`).join('\n');
    if (box.dataset.shown === shown) return;
    box.dataset.shown = shown;
    box.textContent = '';
    for (const [kind, { text }] of this.advice) surfit.element('p', box, { className: kind, textContent: text });
  }

  showLink(text, isBad) {
    const link = surfit.byId('link');
    link.hidden = !text;
    link.textContent = text;
    link.className = `pill ${isBad ? 'bad' : 'plain'}`;
  }

  // Replaces all pictures at the same time, after decoding.
  async showPictures(ids, blobs) {
    const ready = blobs.map((blob) => Object.assign(new Image(), { src: URL.createObjectURL(blob) }));
    await Promise.all(ready.map((image) => image.decode()));
    ids.forEach((id, i) => {
      const image = surfit.byId(id);
      if (image.src.startsWith('blob:')) URL.revokeObjectURL(image.src);
      image.src = ready[i].src;
    });
  }
};
