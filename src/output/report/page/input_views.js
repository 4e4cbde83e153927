'use strict';
// What the frames saw beside what the map showed from there: one slider a run.
surfit.pictureNames = { input_color: 'input', model_color: 'model', input_depth: 'input depth',
  model_depth: 'model depth, same colours' };

surfit.showView = (run, view, title, pictures) => {
  title.textContent = ` frame ${view.index}, ${view.stamp_s.toFixed(3)} s: ${view.why}`;
  pictures.textContent = '';
  for (const [name, url] of Object.entries(view.pictures)) {
    const figure = surfit.element('figure', pictures);
    surfit.element('img', figure, { src: url, alt: `${surfit.pictureNames[name]} of frame ${view.index}` });
    surfit.element('figcaption', figure, { textContent: surfit.pictureNames[name] });
  }
};

surfit.showViews = (runs) => {
  for (const run of runs) {
    const { views } = run.poses;
    const column = surfit.element('div', surfit.byId('view-columns'), { className: 'views' });
    surfit.element('h3', column, { textContent: run.label });
    if (views.length === 0) {
      surfit.element('p', column, { className: 'note',
        textContent: 'This run kept no views: surfit_slam keeps them with --report.' });
      continue;
    }
    const slider = surfit.element('input', column, { type: 'range', min: 0, max: views.length - 1,
      value: Math.floor(views.length / 2) });
    slider.setAttribute('aria-label', `which of ${views.length} views of ${run.label}`);
    const title = surfit.element('span', column);
    const pictures = surfit.element('div', column, { className: 'pictures' });
    const show = () => surfit.showView(run, views[slider.value], title, pictures);
    slider.addEventListener('input', show);
    surfit.whenInSight(column, show);
  }
};
