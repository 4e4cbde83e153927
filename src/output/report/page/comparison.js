'use strict';
// Page of a comparison of solvers. src/apps/solvers/comparison_page.cc writes its data.
surfit.timeSeries = [['linearize_ms', 'linearise'], ['solve_ms', 'solve'], ['total_ms', 'total']];

surfit.groupOf = (row) => `${row.residual}, ${row.association}`;

surfit.figure = (value) => {
  if (value === null) return '–';
  return value < 100 ? String(Number(value.toPrecision(3))) : value.toFixed(0);
};

// Exponents of the powers of ten around all times.
surfit.timeRange = (rows) => {
  const logs = rows.flatMap((row) => surfit.timeSeries.map(([key]) => row[key]))
    .filter((value) => value > 0).map(Math.log10);
  const low = Math.floor(Math.min(...logs));
  return [low, Math.max(Math.ceil(Math.max(...logs)), low + 1)];
};

surfit.addTimeHead = (table, [low, high]) => {
  const row = surfit.element('tr', surfit.element('thead', table));
  surfit.element('th', row, { textContent: 'ms' });
  const scale = surfit.element('div', surfit.element('th', row), { className: 'dots' });
  for (let power = low; power <= high; ++power) {
    const tick = surfit.element('span', scale, { className: 'tick', textContent: Number(`1e${power}`) });
    tick.style.left = `${100 * (power - low) / (high - low)}%`;
  }
  surfit.timeSeries.forEach(([, name], i) => {
    const head = surfit.element('th', row, { className: 'number', textContent: name });
    head.style.color = surfit.runColor(i);
  });
};

surfit.addTimeRow = (body, row, [low, high], manyThreads) => {
  const line = surfit.element('tr', body);
  surfit.element('td', line, { textContent: manyThreads ? `${row.title}, ${row.threads} threads` : row.title });
  const dots = surfit.element('div', surfit.element('td', line), { className: 'dots' });
  dots.style.backgroundSize = `${100 / (high - low)}% 100%`;
  surfit.timeSeries.forEach(([key], i) => {
    surfit.element('td', line, { className: 'number', textContent: surfit.figure(row[key]) });
    if (!(row[key] > 0)) return;
    const dot = surfit.element('span', dots, { className: 'dot' });
    dot.style.left = `${100 * (Math.log10(row[key]) - low) / (high - low)}%`;
    dot.style.background = surfit.runColor(i);
  });
};

surfit.showTimes = (rows) => {
  const range = surfit.timeRange(rows);
  const manyThreads = rows.some((row) => row.threads !== rows[0].threads);
  const table = surfit.element('table', surfit.byId('times'), { className: 'times' });
  surfit.addTimeHead(table, range);
  for (const [title, group] of surfit.groupBy(rows, surfit.groupOf)) {
    const body = surfit.element('tbody', table);
    surfit.element('th', surfit.element('tr', body), { textContent: title, colSpan: 5 });
    for (const row of group) surfit.addTimeRow(body, row, range, manyThreads);
  }
};

// Adds a table of ratios as coloured percentages, with their intervals as tooltips.
surfit.addShares = (parent, shares, rowLabels, columnLabels) => {
  const table = surfit.element('table', parent, { className: 'shares' });
  const head = surfit.element('tr', table);
  surfit.element('th', head);
  for (const label of columnLabels) surfit.element('th', head, { textContent: label });
  shares.forEach((row, i) => {
    const line = surfit.element('tr', table);
    surfit.element('th', line, { textContent: rowLabels[i] });
    for (const element of row) {
      const cell = surfit.element('td', line);
      if (element === null) continue;
      const [share, low, high] = element;
      cell.textContent = Math.round(100 * share);
      cell.title = `95 % interval: ${Math.round(100 * low)} to ${Math.round(100 * high)} %`;
      cell.style.background = surfit.cssColor(surfit.scaleColor(share, 0, 1));
      cell.style.color = share > 0.6 ? '#141414' : '#ffffff';
    }
  });
};

surfit.showBasins = (rows, data) => {
  surfit.byId('basins').hidden = !rows.some((row) => row.shares);
  if (surfit.byId('basins').hidden) return;
  surfit.byId('basins-title').textContent = `Percentage of initial poses with a final error below ${
    data.max_rotation_error_deg} deg and ${data.max_translation_error_m} m`;
  const residuals = [...surfit.groupBy(rows, (row) => row.residual).keys()];
  const table = surfit.element('table', surfit.byId('basins'), { className: 'basins' });
  const head = surfit.element('tr', table);
  surfit.element('th', head);
  for (const residual of residuals) surfit.element('th', head, { textContent: residual });
  for (const [title, group] of surfit.groupBy(rows, (row) => `${row.title}, ${row.association}`)) {
    const line = surfit.element('tr', table);
    surfit.element('th', line, { textContent: title });
    for (const residual of residuals) {
      const cell = surfit.element('td', line);
      const row = group.find((candidate) => candidate.residual === residual);
      if (row) surfit.addShares(cell, row.shares, data.rotations_deg, data.translations_m);
    }
  }
};

// Coinciding lines are all visible: later lines are wider and below.
surfit.showLosses = (rows, data) => {
  const widest = 9, narrowest = 1.5;
  const titles = [...surfit.groupBy(rows, (row) => row.title).keys()];
  surfit.byId('losses-title').textContent = data.refinement ? 'Cost at each iteration'
    : `Loss at each iteration, initial pose error ${data.start.rotation_deg} deg and ${
      data.start.translation_m} m`;
  for (const [title, group] of surfit.groupBy(rows, surfit.groupOf)) {
    const lines = group.map((row) => {
      const i = titles.indexOf(row.title);
      return surfit.line(row.title, surfit.runColor(i),
        row.losses.map((y, x) => ({ x, y })).filter(({ y }) => y > 0),
        { borderWidth: narrowest + (widest - narrowest) * i / Math.max(1, titles.length - 1) });
    });
    surfit.addChart(surfit.byId('loss-charts'), title, lines, {
      x: surfit.axis('iteration'), y: surfit.axis(data.refinement ? 'cost' : 'm²', { type: 'logarithmic' }), className: 'chart high' });
  }
};

surfit.showFigures = (rows) => {
  const names = Object.keys(rows[0]).filter((name) => !['title', 'shares', 'losses'].includes(name));
  surfit.addTable(surfit.byId('figures-table'), names.map((name) => name.replaceAll('_', ' ')),
    rows.map((row) => names.map((name) => surfit.cellText(row[name], '–'))));
};

(() => {
  surfit.connectTheme();
  const [data] = surfit.takeData('comparison');
  const once = data.rows.filter((row) => row.threads === data.rows[0].threads);  // results do not depend on threads
  surfit.byId('headline').textContent = data.notes.map((note) => `Note: ${note}.`).join(' ');
  surfit.byId('times-note').hidden = data.known_pairs || data.refinement;
  surfit.showTimes(data.rows);
  surfit.showBasins(once, data);
  surfit.showLosses(once, data);
  surfit.showFigures(data.rows);
  document.documentElement.dataset.readyMs = performance.now().toFixed(0);
})();
