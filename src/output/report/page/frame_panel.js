'use strict';
// Panel of one frame: input pictures, model pictures and statistics. Pictures come from the thumbnail of the frame or
// from its stored view, which is larger. Frames without pictures show those of the nearest frame.

surfit.pictureNames = { input_color: 'input', model_color: 'model', input_depth: 'input depth',
  model_depth: 'model depth, same colour scale' };

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
      facts.push(`${(100 * frames.inlier_ratio[row]).toFixed(0)} % inliers`,
        `RMSE ${(1000 * frames.rmse_m[row]).toFixed(1)} mm`);
    }
  }
  if (run.errors.has(frame)) facts.push(`position error ${(1000 * run.errors.get(frame)).toFixed(1)} mm`);
  const count = (kind) => run.loops.filter(
    (loop) => loop.kind === kind && (loop.source === frame || loop.target === frame)).length;
  if (run.loops.length > 0) facts.push(`loops: ${count('accepted')}, rejected: ${count('refused')}`);
  return facts.join(', ');
};

// Appends at most `most` pictures of the nearest frame with pictures. If this is another frame, the caption names it.
surfit.addFramePictures = (parent, run, frame, most = Infinity) => {
  const view = surfit.nearestPicture(run, frame);
  if (view) surfit.addPictures(parent, view, most, view.index === frame ? ''
    : ` of frame ${view.index}, the nearest with pictures`);
};

surfit.addPictures = (parent, view, most = Infinity, note = '') => {
  for (const [name, url] of Object.entries(view.pictures).slice(0, most)) {
    surfit.addFigure(parent, url, surfit.pictureNames[name], view.index, note);
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
  const text = run.poseOfFrame.has(frame) ? '' : '; no pose';
  surfit.byId('frame-facts').textContent = surfit.frameFacts(run, frame) + text;
  surfit.byId('look-from-frame').disabled = !run.poseOfFrame.has(frame) || !surfit.mapView;
  for (const [id, most] of [['frame-pictures', Infinity], ['map-frame-pictures', 2]]) {
    surfit.byId(id).textContent = '';
    surfit.addFramePictures(surfit.byId(id), run, frame, most);
  }
  surfit.byId('map-frame-facts').textContent = surfit.frameFacts(run, frame);
  const near = surfit.nearestPicture(run, frame);
  for (const button of surfit.byId('thumbnails').children) {
    const isIt = near && Number(button.dataset.frame) === near.index;
    button.setAttribute('aria-current', String(Boolean(isIt)));
    if (isIt) surfit.scrollAlong(surfit.byId('thumbnails'), button);
  }
  if (surfit.mapView) surfit.mapView.select(run, [frame]);
};

// Replaces scrollIntoView(), which would scroll the page as well.
surfit.scrollAlong = (strip, button) => {
  strip.scrollLeft = button.offsetLeft - strip.offsetLeft - (strip.clientWidth - button.clientWidth) / 2;
};

surfit.frameRange = (run) => surfit.range(
  [...(run.frames ? run.frames.index : []), ...run.poses.poses.map((pose) => pose[0])]);

// Selects the next or the previous frame with pictures.
surfit.stepFrame = (step) => {
  const { run, frame } = surfit.selected.run ? surfit.selected : { run: surfit.runs[0], frame: -1 };
  const indices = surfit.picturesOf(run).map((view) => view.index);
  const next = step > 0 ? indices.find((i) => i > frame) : indices.reverse().find((i) => i < frame);
  if (next !== undefined) surfit.selectFrame(run, next);
};

surfit.showNextFrame = (step) => {
  surfit.stepFrame(step);
  surfit.showMapFrame();
};

// Shows the pictures next to the map if the run has pictures.
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
  const selectFirst = (run) => surfit.selectFrame(run, surfit.frameRange(run)[0]);
  surfit.on('frame-run', 'change', () => selectFirst(runs[Number(select.value)]));
  surfit.on('frame-number', 'input', ({ value }) => surfit.selectFrame(surfit.selected.run, Number(value)));
  surfit.on('next-frame', 'click', () => surfit.stepFrame(1));
  surfit.on('previous-frame', 'click', () => surfit.stepFrame(-1));
  surfit.on('look-from-frame', 'click', surfit.lookFromFrame);
  surfit.on('close-map-frame', 'click', () => { surfit.byId('map-frame').hidden = true; });
  surfit.whenInSight(surfit.byId('frame'), () => {
    if (!surfit.selected.run) selectFirst(runs[0]);
  });
};

// Stored views of each run: input next to model, with a slider.
surfit.showViews = (runs) => {
  for (const run of runs) {
    const { views } = run.poses;
    const column = surfit.element('div', surfit.byId('view-columns'), { className: 'views' });
    surfit.element('h3', column, { textContent: run.label });
    if (views.length === 0) {
      surfit.say(column, 'This run has no stored views: surfit_slam stores views with --report.');
      continue;
    }
    const slider = surfit.element('input', column, { type: 'range', min: 0, max: views.length - 1,
      value: Math.floor(views.length / 2), ariaLabel: `one of ${views.length} views of ${run.label}` });
    const title = surfit.element('span', column);
    const pictures = surfit.element('div', column, { className: 'pictures' });
    const show = () => {
      const view = views[slider.value];
      title.textContent = ` frame ${view.index}, ${view.stamp_s.toFixed(3)} s: ${view.why}`;
      pictures.textContent = '';
      surfit.addPictures(pictures, view);
    };
    slider.addEventListener('input', show);
    surfit.whenInSight(column, show);
  }
};
