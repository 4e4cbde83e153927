'use strict';
// Charts of Chart.js with the page's colours, made when they come into sight: a dozen at once would
// take longer than the map. Drag across a chart to zoom, double click to see all of it again.
surfit.charts = [];
surfit.runColors = ['#2f81d6', '#e4572e', '#3a9d5d', '#9b5de5', '#c98b00', '#00a5a5', '#e06fae', '#8f7258',
  '#8a949e'];
surfit.runColor = (i) => surfit.runColors[i % surfit.runColors.length];

surfit.themeColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

surfit.axis = (text, more = {}) => ({ title: { display: true, text }, ...more });

surfit.line = (label, color, data, more = {}) => ({
  label, data, borderColor: color, backgroundColor: color, borderWidth: 1.2, pointRadius: 0, ...more });

// Points { x, y } of two columns; what is not finite leaves a gap.
surfit.pairs = (xs, ys) => xs.map((x, i) => ({ x, y: Number.isFinite(ys[i]) ? ys[i] : NaN }));

// Zooming is a plugin's, which a page may lack (src/report/CMakeLists.txt).
surfit.zoomOptions = (mode) => ({ zoom: { mode, drag: { enabled: true, threshold: 5 } } });

surfit.makeChart = (box, title, datasets, { x, y, plugins = {}, zoomMode = 'x' }) => {
  const canvas = surfit.element('canvas', box);
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `${title}: ${datasets.map((set) => set.label).join(', ')}`);
  const chart = new Chart(canvas, {
    type: 'line',
    data: { datasets },
    options: {
      animation: false, parsing: false, normalized: true, maintainAspectRatio: false,
      interaction: { mode: 'nearest', axis: 'x', intersect: false },
      scales: { x: { type: 'linear', ...x }, y },
      plugins: { title: { display: true, text: title },
        legend: { labels: { boxWidth: 14, boxHeight: 2 } }, zoom: surfit.zoomOptions(zoomMode), ...plugins },
    },
  });
  if (chart.resetZoom) canvas.addEventListener('dblclick', () => chart.resetZoom('none'));
  surfit.charts.push(chart);
  return chart;
};

// `made` is called with the chart.
surfit.addChart = (parent, title, datasets, options, made = () => {}) => {
  const box = surfit.element('div', parent, { className: options.className || 'chart' });
  surfit.whenInSight(box, () => made(surfit.makeChart(box, title, datasets, options)));
};

surfit.applyTheme = (theme) => {
  document.documentElement.dataset.theme = theme;
  Chart.defaults.color = surfit.themeColor('--ink');
  Chart.defaults.borderColor = surfit.themeColor('--line');
  for (const chart of surfit.charts) {
    for (const scale of Object.values(chart.options.scales)) {
      scale.grid = { ...scale.grid, color: Chart.defaults.borderColor };
      scale.ticks = { ...scale.ticks, color: Chart.defaults.color };
      scale.title.color = Chart.defaults.color;
    }
    chart.options.plugins.title.color = Chart.defaults.color;
    chart.options.plugins.legend.labels.color = Chart.defaults.color;
    chart.update('none');
  }
};

// As the system has it, until the button is pressed.
surfit.connectTheme = () => {
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const system = () => surfit.applyTheme(dark.matches ? 'dark' : 'light');
  dark.addEventListener('change', system);
  surfit.byId('theme').addEventListener('click', () => {
    surfit.applyTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  });
  system();
};
