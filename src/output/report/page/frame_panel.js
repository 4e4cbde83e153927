'use strict';
// One frame: what it saw beside the model's view from there, and what is known of it. Pictures are those of
// its thumbnail, or of a kept view, which are larger; of other frames those of the nearest that has some.

surfit.picturesOf = (run) => {
  if (!run.pictures) {
    const byFrame = new Map(run.poses.thumbnails.map((view) => [view.index, view]));
    for (const view of run.poses.views) byFrame.set(view.index, view);
    run.pictures = [...byFrame.values()].sort((a, b) => a.index - b.index);
  }
  return run.pictures;
};

surfit.nearestPicture = (run, frame) => surfit.picturesOf(run).reduce((best, view) => (
  best && Math.abs(best.index - frame) <= Math.abs(view.index - frame) ? best : view), null);

surfit.frameFacts = (run, frame) => {
  const facts = [`frame ${frame}`];
  const { frames } = run;
  const row = frames ? frames.index.indexOf(frame) : -1;
  if (row >= 0) {
    facts.push(frames.state[row]);
    if (frames.termination[row]) {
      facts.push(`${(100 * frames.inlier_share[row]).toFixed(0)} % inliers`,
        `RMSE ${(1000 * frames.rmse_m[row]).toFixed(1)} mm`);
    }
  }
  if (run.errors.has(frame)) facts.push(`${(1000 * run.errors.get(frame)).toFixed(1)} mm from the truth`);
  const count = (kind) => run.loops.filter(
    (loop) => loop.kind === kind && (loop.source === frame || loop.target === frame)).length;
  if (run.loops.length > 0) facts.push(`loops: ${count('accepted')}, refused: ${count('refused')}`);
  return facts.join(', ');
};

// At most so many into `parent`, with the frame that they are of where it is not the one asked for.
surfit.showFramePictures = (parent, run, frame, most = Infinity) => {
  parent.textContent = '';
  surfit.addFramePictures(parent, run, frame, most);
};

surfit.addFramePictures = (parent, run, frame, most) => {
  const view = surfit.nearestPicture(run, frame);
  if (!view) return;
  const note = view.index === frame ? '' : ` of frame ${view.index}, the nearest with pictures`;
  for (const [name, url] of Object.entries(view.pictures).slice(0, most)) {
    const figure = surfit.element('figure', parent);
    surfit.element('img', figure, { src: url, alt: `${surfit.pictureNames[name]} of frame ${view.index}` });
    surfit.element('figcaption', figure, { textContent: surfit.pictureNames[name] + note });
  }
};

surfit.showThumbnails = (run) => {
  const strip = surfit.byId('thumbnails');
  strip.textContent = '';
  for (const view of surfit.picturesOf(run)) {
    const button = surfit.element('button', strip, { type: 'button', className: 'thumbnail' });
    button.dataset.frame = view.index;
    surfit.element('img', button, { src: Object.values(view.pictures)[0], alt: '', loading: 'lazy' });
    surfit.element('span', button, { textContent: view.index });
    button.setAttribute('aria-label', `frame ${view.index}`);
    button.addEventListener('click', () => surfit.selectFrame(run, view.index));
  }
};

surfit.selected = { run: null, frame: -1 };

surfit.selectFrame = (run, frame) => {
  if (surfit.selected.run !== run) {
    surfit.byId('frame-run').value = String(surfit.runs.indexOf(run));
    surfit.showThumbnails(run);
    const slider = surfit.byId('frame-number');
    [slider.min, slider.max] = surfit.frameRange(run);
  }
  surfit.selected = { run, frame };
  surfit.byId('frame-number').value = frame;
  const text = run.poseOfFrame.has(frame) ? '' : '; it has no pose';
  surfit.byId('frame-facts').textContent = surfit.frameFacts(run, frame) + text;
  surfit.byId('look-from-frame').disabled = !run.poseOfFrame.has(frame) || !surfit.mapView;
  surfit.showFramePictures(surfit.byId('frame-pictures'), run, frame);
  surfit.showFramePictures(surfit.byId('map-frame-pictures'), run, frame, 2);
  surfit.byId('map-frame-facts').textContent = surfit.frameFacts(run, frame);
  const near = surfit.nearestPicture(run, frame);
  for (const button of surfit.byId('thumbnails').children) {
    const isIt = near && Number(button.dataset.frame) === near.index;
    button.setAttribute('aria-current', String(Boolean(isIt)));
    if (isIt) surfit.scrollAlong(surfit.byId('thumbnails'), button);
  }
  if (surfit.mapView) surfit.mapView.select(run, [frame]);
};

// Not scrollIntoView(), which would move the page as well.
surfit.scrollAlong = (strip, button) => {
  strip.scrollLeft = button.offsetLeft - strip.offsetLeft - (strip.clientWidth - button.clientWidth) / 2;
};

surfit.frameRange = (run) => surfit.range(
  [...(run.frames ? run.frames.index : []), ...run.poses.poses.map((pose) => pose[0])]);

// To the next frame that has a picture, or the one before.
surfit.stepFrame = (step) => {
  const { run, frame } = surfit.selected.run ? surfit.selected : { run: surfit.runs[0], frame: -1 };
  const indices = surfit.picturesOf(run).map((view) => view.index);
  const next = step > 0 ? indices.find((i) => i > frame) : indices.reverse().find((i) => i < frame);
  if (next !== undefined) surfit.selectFrame(run, next);
};

// Beside the map, for who looks there.
surfit.showMapFrame = () => {
  const { run } = surfit.selected;
  surfit.byId('map-frame').hidden = !run || surfit.picturesOf(run).length === 0;
};

surfit.lookFromFrame = () => {
  const { run, frame } = surfit.selected;
  if (surfit.mapView && run.poseOfFrame.has(frame)) surfit.mapView.lookFrom(run, run.poseOfFrame.get(frame));
};

surfit.showFramePanel = (runs) => {
  const select = surfit.byId('frame-run');
  runs.forEach((run, i) => surfit.element('option', select, { value: i, textContent: run.label }));
  surfit.byId('frame-run-label').hidden = runs.length < 2;
  select.addEventListener('change', () => {
    const run = runs[Number(select.value)];
    surfit.selectFrame(run, surfit.frameRange(run)[0]);
  });
  surfit.byId('frame-number').addEventListener('input', (event) => {
    surfit.selectFrame(surfit.selected.run, Number(event.target.value));
  });
  surfit.byId('next-frame').addEventListener('click', () => surfit.stepFrame(1));
  surfit.byId('previous-frame').addEventListener('click', () => surfit.stepFrame(-1));
  surfit.byId('look-from-frame').addEventListener('click', surfit.lookFromFrame);
  surfit.byId('close-map-frame').addEventListener('click', () => { surfit.byId('map-frame').hidden = true; });
  surfit.whenInSight(surfit.byId('frame'), () => {
    if (!surfit.selected.run) surfit.selectFrame(runs[0], surfit.frameRange(runs[0])[0]);
  });
};
