// What `touchdown watch --web` draws. Colours that colour-blind people tell apart; lines differ in their dashes, too.
'use strict';

const WINDOW_S = 10;
const BLUE = '#0072b2', ORANGE = '#d55e00', BLACK = '#000';
const byId = (id) => document.getElementById(id);
let points = [], snapshot = null;

const fixed = (value, digits) => Number.isFinite(value) ? value.toFixed(digits) : '-';
const mm = (metres, digits = 3) => fixed(metres * 1e3, digits);
const us = (times) => times.max === 0 ? '-'
  : [times.p50, times.p99, times.max].map((seconds) => fixed(seconds * 1e6, 0)).join(' ');

// A table of texts; text never becomes markup.
function fill(table, rows) {
  table.replaceChildren(...rows.map(({ cells, head, style }) => {
    const row = document.createElement('tr');
    if (style) row.className = style;
    row.append(...cells.map((text) => {
      const cell = document.createElement(head ? 'th' : 'td');
      cell.textContent = text;
      return cell;
    }));
    return row;
  }));
}

// The context of a canvas in CSS pixels, cleared.
function cleared(canvas) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = Number(canvas.dataset.height);
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.font = '11px system-ui, sans-serif';
  return { context, width, height };
}

// A step of 1, 2 or 5 times a power of ten that divides `span` into some five parts.
function nice(span) {
  const power = 10 ** Math.floor(Math.log10(span / 5)), part = span / 5 / power;
  return power * (part > 5 ? 10 : part > 2 ? 5 : part > 1 ? 2 : 1);
}

// Lines over time: each { name, colour, dash, of }, where `of` takes a point and gives a number or null.
function plot(canvas, lines) {
  const { context, width, height } = cleared(canvas);
  const left = 46, right = width - 8, top = 18, bottom = height - 18;
  const end = points.length ? points[points.length - 1][0] : WINDOW_S, start = end - WINDOW_S;
  let low = Infinity, high = -Infinity;
  for (const point of points) for (const { of } of lines) {
    const value = of(point);
    if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); }
  }
  if (low > high) { low = 0; high = 1; }
  const room = 0.05 * (high - low) + 0.05;
  low -= room; high += room;
  const x = (time) => left + (time - start) / WINDOW_S * (right - left);
  const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);

  context.fillStyle = '#444'; context.strokeStyle = '#ddd'; context.lineWidth = 1;
  const step = nice(high - low), digits = Math.max(0, -Math.floor(Math.log10(step)));
  context.textAlign = 'right'; context.textBaseline = 'middle';
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
    context.beginPath(); context.moveTo(left, y(value)); context.lineTo(right, y(value)); context.stroke();
    context.fillText(fixed(value, digits), left - 5, y(value));
  }
  context.textAlign = 'center'; context.textBaseline = 'top';
  for (let time = Math.ceil(start / 2) * 2; time <= end; time += 2) {
    if (time >= 0) context.fillText(fixed(time, 0), x(time), bottom + 4);
  }
  context.save();
  context.beginPath(); context.rect(left, top, right - left, bottom - top); context.clip();
  for (const { colour, dash, of } of lines) {
    context.strokeStyle = colour; context.setLineDash(dash); context.lineWidth = 1.5;
    context.beginPath();
    let drawn = false;
    for (const point of points) {
      const value = of(point);
      if (value === null) { drawn = false; continue; }
      if (drawn) context.lineTo(x(point[0]), y(value)); else context.moveTo(x(point[0]), y(value));
      drawn = true;
    }
    context.stroke();
  }
  context.restore();
  context.setLineDash([]); context.textAlign = 'left'; context.textBaseline = 'middle';
  let at = left;
  for (const { name, colour, dash } of lines) {
    context.strokeStyle = colour; context.setLineDash(dash); context.lineWidth = 2;
    context.beginPath(); context.moveTo(at, 9); context.lineTo(at + 24, 9); context.stroke();
    context.setLineDash([]); context.fillText(name, at + 29, 9);
    at += 44 + context.measureText(name).width;
  }
}

// Tool and object from the side: x to the right, z up, to scale but for the tool, whose spring is drawn `magnified`.
function scene(canvas) {
  const { context, width, height } = cleared(canvas);
  const controller = snapshot.controller, sensor = snapshot.sensor;
  if (!controller) return;
  const [x, , z] = controller.tcp_position_m, object = controller.object_position_m;
  const gap = object ? Math.abs(z - object[2]) : 0;
  const half = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5].find((half) => gap < 0.8 * half) ?? 1;
  const scale = 0.3 * height / half, ground = 0.62 * height;
  const surface = object ? object[2] : z;
  const up = (metres) => ground - (metres - surface) * scale;
  const tip = { x: width / 2, y: up(z) };

  // The object: its surface and what is below.
  context.strokeStyle = ORANGE; context.fillStyle = '#fbe6d8'; context.lineWidth = 2;
  if (object) {
    context.fillRect(0, ground, width, height - ground);
    context.beginPath(); context.moveTo(0, ground); context.lineTo(width, ground); context.stroke();
  }
  // The tool along its axis, and the flange where it would be without load, as far away as the spring is long.
  const tare = controller.tare_translation_m;
  const deflection = sensor ? sensor.translation_m.map((value, i) => value - tare[i]) : [0, 0, 0];
  const most = Math.hypot(deflection[0], deflection[2]);
  const magnified = [1000, 500, 200, 100, 50, 20, 10, 5, 2].find((factor) => most * factor * scale < 30) ?? 1;
  const [ax, , az] = controller.tool_axis, length = 0.2 * height, rest = 0.16 * height;
  const top = { x: tip.x + ax * length, y: tip.y - az * length };
  const flange = {
    x: top.x + ax * rest - deflection[0] * magnified * scale,
    y: top.y - az * rest + deflection[2] * magnified * scale,
  };
  context.strokeStyle = BLUE; context.fillStyle = BLUE; context.lineWidth = 5;
  context.beginPath(); context.moveTo(top.x, top.y); context.lineTo(tip.x, tip.y); context.stroke();
  context.beginPath(); context.arc(tip.x, tip.y, 4, 0, 2 * Math.PI); context.fill();
  context.lineWidth = 2;
  context.beginPath(); context.moveTo(top.x - 22, top.y); context.lineTo(top.x + 22, top.y); context.stroke();
  context.strokeStyle = '#444';
  context.beginPath(); context.moveTo(top.x, top.y);
  for (let turn = 0; turn < 8; turn++) {
    const share = (turn + 0.5) / 8, side = turn % 2 ? 9 : -9;
    context.lineTo(top.x + share * (flange.x - top.x) + side, top.y + share * (flange.y - top.y));
  }
  context.lineTo(flange.x, flange.y); context.stroke();
  context.fillStyle = '#444'; context.fillRect(flange.x - 34, flange.y - 10, 68, 10);
  // The force that the object exerts on the tool.
  const force = controller.normal_force_n, arrow = Math.max(-60, Math.min(60, 4 * force));
  if (Math.abs(arrow) > 2) {
    const at = tip.x + 60, head = arrow > 0 ? 7 : -7;
    context.strokeStyle = context.fillStyle = ORANGE; context.lineWidth = 3;
    context.beginPath(); context.moveTo(at, ground); context.lineTo(at, ground - arrow); context.stroke();
    context.beginPath(); context.moveTo(at - 6, ground - arrow + head); context.lineTo(at + 6, ground - arrow + head);
    context.lineTo(at, ground - arrow - head); context.fill();
  }
  context.fillStyle = '#111'; context.textBaseline = 'middle'; context.textAlign = 'left';
  if (Math.abs(arrow) > 2) context.fillText(`${fixed(force, 2)} N`, tip.x + 72, ground - arrow / 2);
  context.fillText(object ? `object ${mm(object[2])} mm` : 'object unknown', 8, ground + 14);
  context.fillText(`tcp ${mm(x)} ${mm(z)} mm (x, z)`, 8, 12);
  context.fillText(`deflection ${mm(deflection[0])} ${mm(deflection[2])} mm (x, z), drawn ${magnified} times`, 8, 28);
  // How long a length is.
  context.strokeStyle = '#111'; context.lineWidth = 2;
  const bar = half / 2 * scale;
  context.beginPath(); context.moveTo(width - 12 - bar, height - 12); context.lineTo(width - 12, height - 12); context.stroke();
  context.textAlign = 'right'; context.fillText(`${mm(half / 2, 1)} mm`, width - 12, height - 24);
  byId('scene-title').textContent = 'Side view: x to the right, z up; spring of the sensor magnified, tool not to scale';
}

function tables() {
  const columns = ['node', 'host', 'state', 'age ms', 'Hz', 'loss %', 'lost', 'dropped', 'refused', 'missed', 'answer',
    'lateness', 'round trip', 'age at use'];
  const rows = snapshot.nodes.map((row) => ({
    style: row.fault ? 'bad' : row.silent ? 'quiet' : '',
    cells: [row.node, row.host, (row.silent && row.age_s !== null ? 'silent' : row.state) + (row.fault ? `: ${row.fault}` : ''),
      row.age_s === null ? '-' : fixed(row.age_s * 1e3, 0), fixed(row.rate_hz, 0), fixed(row.loss_ratio * 100, 1),
      row.lost, row.dropped + (row.kernel_dropped ?? 0), row.refused, row.missed, us(row.answer_s), us(row.lateness_s),
      us(row.round_trip_s), us(row.age_at_use_s),],
  }));
  fill(byId('nodes'), [{ head: true, cells: columns }, ...rows]);

  const row = snapshot.controller, state = byId('state');
  if (!row) { state.textContent = 'no controller is heard'; fill(byId('values'), []); return; }
  const step = row.program_step === null ? '' : ` (${row.program_step})`;
  state.textContent = `${fixed(row.time_s, 3)} s: ${row.phase}${step}${row.fault ? `: ${row.fault}` : ''}`
    + (row.silent ? `; silent for ${fixed(row.age_s, 1)} s` : '');
  state.className = row.fault ? 'bad' : row.silent ? 'quiet' : '';
  const place = (position) => `${position.map((metres) => mm(metres)).join(' ')} mm`;
  const impact = row.impact, detection = row.detection;
  const allowed = impact.speed_limit_m_per_s === null ? 'any force allowed' : `allowed ${mm(impact.speed_limit_m_per_s, 1)} mm/s`;
  const values = [
    ['force', `${fixed(row.normal_force_n, 2)} N of ${fixed(row.desired_force_n[2], 2)} N, error ${fixed(row.force_error_n, 2)} N`],
    ['by deflection', `${row.force_n.map((value) => fixed(value, 2)).join(' ')} N`],
    ['moment', `${row.moment_nm.map((value) => fixed(value, 3)).join(' ')} Nm`],
    ['tcp', place(row.tcp_position_m)],
    ['object', row.object_position_m ? `${place(row.object_position_m)}, ${mm(row.object_velocity_m_per_s[2], 2)} mm/s up` : 'unknown'],
    ['detection', `${fixed(detection.statistic_n, 2)} N, threshold ${fixed(detection.threshold_n, 2)} N`
      + (detection.contact_time_s === null ? '' : `, contact at ${fixed(detection.contact_time_s, 3)} s`)],
    ['impact', `${fixed(impact.peak_force_n, 1)} N peak at ${mm(impact.speed_m_per_s, 1)} mm/s (${allowed}), `
      + `${fixed(impact.effective_mass_kg, 2)} kg, ${fixed(impact.maximum_depth_m * 1e6, 1)} um, ${fixed(impact.characteristic_time_s * 1e3, 2)} ms`],
    ['margins', row.gain_margin === null ? 'not assessed'
      : `gain ${fixed(row.gain_margin, 1)}, phase ${fixed(row.phase_margin_rad * 180 / Math.PI, 0)}°, oscillation ${fixed(row.oscillation_n, 2)} N`],
    ['law', row.law],
    ['limits', row.limits.join(', ') || 'none'],
    ['last answer', row.answer ?? '-'],
  ];
  const clocks = snapshot.nodes.flatMap((node) => node.clocks);
  if (clocks.length) values.push(['clocks', clocks.map((clock) =>
    `${clock.whose} ${fixed(clock.offset_s, 6)} s ± ${fixed(clock.bound_s * 1e6, 0)} us`).join(', ')]);
  if (snapshot.robot) values.push(['robot', `${snapshot.robot.mode}${snapshot.robot.fault ? `: ${snapshot.robot.fault}` : ''}, `
    + `${snapshot.robot.missed_commands} commands missed`]);
  if (snapshot.object) values.push(['non-contact', snapshot.object.visible ? place(snapshot.object.position_m) : 'not seen']);
  fill(byId('values'), values.map((cells) => ({ cells })));
}

function draw() {
  if (!snapshot) return;
  tables();
  plot(byId('force'), [
    { name: 'measured', colour: BLUE, dash: [], of: (point) => point[1] },
    { name: 'desired', colour: BLACK, dash: [6, 4], of: (point) => point[2] },
  ]);
  plot(byId('height'), [
    { name: 'tcp', colour: BLUE, dash: [], of: (point) => point[3] * 1e3 },
    { name: 'object', colour: ORANGE, dash: [6, 4], of: (point) => point[4] === null ? null : point[4] * 1e3 },
  ]);
  scene(byId('scene'));
  const row = snapshot.controller;
  document.title = row ? `${row.phase}, ${fixed(row.normal_force_n, 2)} N at ${fixed(row.time_s, 3)} s` : 'touchdown watch';
}

addEventListener('error', (event) => { document.title = `error: ${event.message}`; });
for (const canvas of document.querySelectorAll('canvas')) canvas.dataset.height = canvas.getAttribute('height');
const events = new EventSource('/events');
events.onopen = () => { points = []; byId('link').textContent = 'live'; byId('link').className = 'quiet'; };
events.onerror = () => { byId('link').textContent = 'touchdown watch has ended, or has enough clients'; byId('link').className = 'bad'; };
events.onmessage = (event) => {
  const news = JSON.parse(event.data);
  if (news.anew) points = [];
  points.push(...news.points);
  const newest = points.length ? points[points.length - 1][0] : 0;
  points = points.filter((point) => point[0] >= newest - WINDOW_S);
  snapshot = news.snapshot;
  requestAnimationFrame(draw);
};
addEventListener('resize', draw);
