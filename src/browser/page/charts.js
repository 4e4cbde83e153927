'use strict';
// Charts of Chart.js in the colours of the page. A chart is created shortly before it becomes visible, because
// creating all charts of a report takes longer than the map. Dragging zooms, a double click resets the zoom.
surfit.charts = [];
surfit.runColors = ['#2f81d6', '#e4572e', '#3a9d5d', '#9b5de5', '#c98b00', '#00a5a5', '#e06fae', '#8f7258',
  '#8a949e'];
surfit.runColor = (i) => surfit.runColors[i % surfit.runColors.length];

surfit.axis = (text, more = {}) => ({ title: { display: true, text }, ...more });

surfit.line = (label, color, data, more = {}) => ({
  label, data, borderColor: color, backgroundColor: color, borderWidth: 1.2, pointRadius: 0, ...more });

// One line per run. dataOf(run) returns its points.
surfit.runLines = (runs, dataOf, more = {}) => runs.map(
  (run, i) => surfit.line(run.label, surfit.runColor(i), dataOf(run), more));

// Points { x, y } of two columns. Non-finite values become gaps.
surfit.pairs = (xs, ys) => xs.map((x, i) => ({ x, y: Number.isFinite(ys[i]) ? ys[i] : NaN }));

// Calls `made` with the chart. Zooming needs a plugin, which is optional (src/browser/CMakeLists.txt).
surfit.addChart = (parent, title, datasets, { x, y, className = 'chart', plugins = {}, zoomMode: mode = 'x' },
  made = () => {}) => {
  const box = surfit.element('div', parent, { className });
  surfit.whenInSight(box, () => {
    const canvas = surfit.element('canvas', box, { role: 'img',
      ariaLabel: `${title}: ${datasets.map((set) => set.label).join(', ')}` });
    const chart = new Chart(canvas, {
      type: 'line',
      data: { datasets },
      options: {
        animation: false, parsing: false, normalized: true, maintainAspectRatio: false,
        interaction: { mode: 'nearest', axis: 'x', intersect: false },
        scales: { x: { type: 'linear', ...x }, y },
        plugins: { title: { display: true, text: title }, legend: { labels: { boxWidth: 14, boxHeight: 2 } },
          zoom: { zoom: { mode, drag: { enabled: true, threshold: 5 } } }, ...plugins },
      },
    });
    if (chart.resetZoom) canvas.addEventListener('dblclick', () => chart.resetZoom('none'));
    surfit.charts.push(chart);
    made(chart);
  });
};

surfit.themeColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

surfit.applyTheme = (theme) => {
  document.documentElement.dataset.theme = theme;
  for (const chart of surfit.charts) chart.update('none');
};

// Connects the theme button of the header. The system theme is used until the button is pressed.
surfit.connectTheme = () => {
  Chart.defaults.color = () => surfit.themeColor('--ink');
  Chart.defaults.borderColor = () => surfit.themeColor('--line');
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const system = () => surfit.applyTheme(dark.matches ? 'dark' : 'light');
  dark.addEventListener('change', system);
  surfit.on('theme', 'click', () => {
    surfit.applyTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  });
  system();
  for (const hint of document.querySelectorAll('.zoom-hint')) hint.hidden = !window.ChartZoom;
};
