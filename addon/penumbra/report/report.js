"use strict";
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const $ = (root, selector) => root.querySelector(selector);
  const $$ = (root, selector) => [...root.querySelectorAll(selector)];
  const escape = text => String(text).replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
  const bytesOf = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const INFERNO = bytesOf(page.inferno), SIGNED = bytesOf(page.signed);
  const SCALES = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1];
  const REFERENCE = -1;
  document.body.classList.add("script");

  /* ---- numbers -------------------------------------------------------------------------------------------------- */

  const figure = value => {
    if (!Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    if (Math.abs(value) < 1e-5) return value.toExponential(1);
    return Number(value.toPrecision(3)).toFixed(Math.max(0, Math.min(7, 2 - Math.floor(Math.log10(Math.abs(value))))));
  };
  const ms = value => value >= 1000 ? `${Number((value / 1000).toPrecision(3))} s`
    : value >= 100 ? `${Math.round(value)} ms` : `${Number(value.toPrecision(3))} ms`;

  /* ---- pixels --------------------------------------------------------------------------------------------------- */

  const LINEAR = Float32Array.from({ length: 256 }, (_, i) => {
    const x = i / 255;
    return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
  });
  const SRGB = Uint8ClampedArray.from({ length: 4096 }, (_, i) => {
    const x = i / 4095;
    return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
  });

  async function pixelsOf(uri) {
    const image = new Image();
    await new Promise((done, fail) => {
      image.onload = done;
      image.onerror = () => fail(new Error("a picture in this page is damaged"));
      image.src = uri;
    });
    const canvas = document.createElement("canvas");
    canvas.width = image.naturalWidth;
    canvas.height = image.naturalHeight;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, canvas.width, canvas.height).data;
  }

  async function visibilityOf(uri) {
    const data = await pixelsOf(uri);
    const values = new Float32Array(data.length / 4);
    const mask = new Uint8Array(values.length);
    for (let i = 0; i < values.length; i++) {
      values[i] = (data[4 * i] * 256 + data[4 * i + 1]) / 65535;
      mask[i] = data[4 * i + 2] > 127 ? 1 : 0;
    }
    return { values, mask };
  }

  const linearOf = async uri => {
    const data = await pixelsOf(uri);
    const values = new Float32Array(data.length / 4 * 3);
    for (let i = 0, o = 0; i < data.length; i += 4) {
      values[o++] = LINEAR[data[i]]; values[o++] = LINEAR[data[i + 1]]; values[o++] = LINEAR[data[i + 2]];
    }
    return values;
  };

  const albedos = new Map();
  const albedoOf = scene => {
    if (!albedos.has(scene)) albedos.set(scene, linearOf(page.albedo[scene]));
    return albedos.get(scene);
  };

  /** All pictures of one light, made from V on demand and kept. */
  class Pictures {
    constructor(light) {
      this.light = light;
      this.kept = new Map();
      this.visibility = new Map();
    }

    async load() {
      const { light } = this;
      const shown = light.records.filter(record => record.picture);
      const [base, albedo, area, irradiance, ...rest] = await Promise.all([
        linearOf(light.base), albedoOf(page.sceneOf[light.key]), visibilityOf(light.area), visibilityOf(light.irradiance),
        ...shown.map(record => visibilityOf(record.picture)),
      ]);
      Object.assign(this, { base, albedo, mask: area.mask, truth: { area: area.values, irradiance: irradiance.values } });
      shown.forEach((record, i) => this.visibility.set(record.index, rest[i].values));
    }

    values(source, truth) { return source === REFERENCE ? this.truth[truth] : this.visibility.get(source); }

    picture(source, mode, truth, scale) {
      const key = [source, mode, source === REFERENCE || mode.length < 7 ? truth : "", mode === "shaded" || mode === "visibility" ? "" : scale, truth].join();
      if (!this.kept.has(key)) {
        if (this.kept.size > 40) this.kept.clear();
        this.kept.set(key, this.make(source, mode, truth, scale));
      }
      return this.kept.get(key);
    }

    make(source, mode, truth, scale) {
      const { light, mask, base, albedo } = this;
      const V = this.values(source, truth), T = this.truth[truth];
      const canvas = document.createElement("canvas");
      canvas.width = light.width;
      canvas.height = light.height;
      const context = canvas.getContext("2d");
      const image = context.createImageData(light.width, light.height);
      const out = image.data;
      const count = V.length;
      if (mode === "shaded") {
        const ambient = light.ambient, gain = light.baseScale;
        for (let i = 0, p = 0, o = 0; i < count; i++, o += 4) {
          const v = V[i] * gain;
          for (let c = 0; c < 3; c++, p++) out[o + c] = SRGB[Math.min(4095, (base[p] * v + albedo[p] * ambient) * 4095 + 0.5 | 0)];
          out[o + 3] = 255;
        }
      } else {
        const table = mode === "signed" ? SIGNED : INFERNO;
        for (let i = 0, o = 0; i < count; i++, o += 4) {
          out[o + 3] = 255;
          if (!mask[i]) { out[o] = out[o + 1] = out[o + 2] = mode === "visibility" ? 40 : 64; continue; }
          if (mode === "visibility") { out[o] = out[o + 1] = out[o + 2] = 255 * V[i]; continue; }
          const error = V[i] - T[i];
          const share = mode === "signed" ? 0.5 + 0.5 * error / scale : Math.abs(error) / scale;
          const k = 3 * Math.max(0, Math.min(255, share * 255 + 0.5 | 0));
          out[o] = table[k]; out[o + 1] = table[k + 1]; out[o + 2] = table[k + 2];
        }
      }
      context.putImageData(image, 0, 0);
      return canvas;
    }
  }

  /* ---- viewer: two pictures under one draggable line ---------------------------------------------------------------- */

  class Viewer {
    constructor(article, light) {
      this.article = article;
      this.light = light;
      this.root = $(article, ".viewer");
      this.canvas = $(this.root, ".stage > canvas");
      this.context = this.canvas.getContext("2d");
      this.stage = $(this.root, ".stage");
      this.wipe = $(this.root, ".wipe");
      this.pictures = new Pictures(light);
      this.shown = light.records.filter(record => record.picture);
      this.split = 0.5;
      this.zoom = 1;
      this.centre = [0.5, 0.5];
      this.mode = "shaded";
      this.truth = "area";
      this.scale = 0.5;
      this.left = REFERENCE;
      this.right = this.shown.length ? this.shown[0].index : REFERENCE;
    }

    get scaleNow() { return this.scale; }
    name(source) { return source === REFERENCE ? "Reference" : this.light.records.find(record => record.index === source).title; }

    async start() {
      await this.pictures.load();
      this.root.hidden = false;
      this.fillSelects();
      this.fillStrip();
      this.listen();
      this.draw();
    }

    fillSelects() {
      const options = [[REFERENCE, "Reference"], ...this.shown.map(record => [record.index, record.title])]
        .map(([value, label]) => `<option value="${value}">${escape(label)}</option>`).join("");
      for (const side of ["left", "right"]) {
        const select = this.control(side);
        select.innerHTML = options;
        select.addEventListener("change", () => this.choose(side, Number(select.value)));
      }
    }

    control(name) { return $(this.root, `[data-control=${name}]`); }

    fillStrip() {
      const strip = $(this.root, ".strip");
      for (const record of this.shown) {
        const button = document.createElement("button");
        button.type = "button";
        button.dataset.record = record.index;
        button.title = "Show on the right (with Shift: on the left)";
        const small = document.createElement("canvas");
        small.width = 264;
        small.height = Math.max(1, Math.round(264 * this.light.height / this.light.width));
        button.append(small);
        button.insertAdjacentHTML("beforeend", `<span>${escape(record.title)}</span><span class="sub">${figure(headline(record, "area"))} · ${ms(record.time.dynamic.median)}</span>`);
        button.addEventListener("click", event => this.choose(event.shiftKey ? "left" : "right", record.index));
        strip.append(button);
      }
    }

    drawStrip() {
      for (const button of $$(this.root, ".strip button")) {
        const small = $(button, "canvas"), context = small.getContext("2d");
        context.imageSmoothingQuality = "high";
        context.drawImage(this.pictures.picture(Number(button.dataset.record), this.mode, this.truth, this.scale), 0, 0, small.width, small.height);
        button.setAttribute("aria-pressed", Number(button.dataset.record) === this.right);
      }
    }

    choose(side, source) {
      this[side] = source;
      this.draw();
      for (const row of $$(this.article, "tr[data-record]")) row.classList.toggle("chosen", Number(row.dataset.record) === this.right);
    }

    swap() { [this.left, this.right] = [this.right, this.left]; this.choose("right", this.right); }

    setMode(mode) {
      this.mode = mode;
      for (const button of $$(this.root, "[data-mode]")) {
        button.setAttribute("aria-checked", button.dataset.mode === mode);
        button.tabIndex = button.dataset.mode === mode ? 0 : -1;
      }
      this.draw();
    }

    listen() {
      const modes = $$(this.root, "[data-mode]");
      modes.forEach((button, i) => {
        button.addEventListener("click", () => this.setMode(button.dataset.mode));
        button.addEventListener("keydown", event => {
          const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
          if (!step) return;
          event.preventDefault();
          const next = modes[(i + step + modes.length) % modes.length];
          this.setMode(next.dataset.mode);
          next.focus();
        });
      });
      this.control("truth").addEventListener("change", event => { this.truth = event.target.value; this.draw(); });
      this.control("swap").addEventListener("click", () => this.swap());
      this.control("in").addEventListener("click", () => this.setZoom(this.zoom * 2, this.centre));
      this.control("out").addEventListener("click", () => this.setZoom(this.zoom / 2, this.centre));
      $(this.root, ".legend input").addEventListener("input", event => { this.scale = SCALES[event.target.value]; this.draw(); });
      this.root.addEventListener("keydown", event => {
        if (event.key.toLowerCase() === "x" && !event.target.matches("input, select")) this.swap();
      });
      this.wipe.addEventListener("keydown", event => {
        const step = { ArrowLeft: -0.02, ArrowDown: -0.02, ArrowRight: 0.02, ArrowUp: 0.02, PageUp: 0.1, PageDown: -0.1, Home: -1, End: 1 }[event.key];
        if (!step) return;
        event.preventDefault();
        this.moveWipe(this.split + step);
      });
      const along = event => {
        const box = this.canvas.getBoundingClientRect();
        return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
      };
      this.wipe.addEventListener("pointerdown", event => { this.wipe.setPointerCapture(event.pointerId); this.dragging = true; event.preventDefault(); this.wipe.focus({ preventScroll: true }); });
      this.wipe.addEventListener("pointermove", event => { if (this.dragging) this.moveWipe(along(event)[0]); });
      for (const end of ["pointerup", "pointercancel"]) this.wipe.addEventListener(end, () => { this.dragging = false; });
      this.canvas.addEventListener("pointerdown", event => {
        this.canvas.setPointerCapture(event.pointerId);
        this.grab = { at: along(event), centre: [...this.centre] };
        if (this.zoom === 1) this.moveWipe(along(event)[0]);
      });
      this.canvas.addEventListener("pointermove", event => {
        const at = along(event);
        if (this.grab && this.zoom === 1) this.moveWipe(at[0]);
        else if (this.grab) this.setZoom(this.zoom, [0, 1].map(k => this.grab.centre[k] - (at[k] - this.grab.at[k]) / this.zoom));
        this.read(at);
      });
      for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => { this.grab = null; });
      this.canvas.addEventListener("dblclick", event => {
        const at = along(event), [x, y] = this.window();
        this.setZoom(this.zoom > 1 ? 1 : 4, [x + at[0] / this.zoom, y + at[1] / this.zoom]);
      });
    }

    moveWipe(share) { this.split = Math.max(0, Math.min(1, share)); this.paint(); }

    setZoom(zoom, centre) {
      this.zoom = Math.max(1, Math.min(16, zoom));
      const half = 0.5 / this.zoom;
      this.centre = centre.map(c => Math.max(half, Math.min(1 - half, c)));
      $(this.root, ".zoom output").textContent = `${this.zoom}×`;
      this.paint();
    }

    window() { return this.centre.map(c => c - 0.5 / this.zoom); }

    read([u, v]) {
      const { width, height } = this.light, [x0, y0] = this.window();
      const x = Math.floor((x0 + u / this.zoom) * width), y = Math.floor((y0 + v / this.zoom) * height);
      const output = $(this.root, ".readout");
      if (x < 0 || y < 0 || x >= width || y >= height) return;
      const i = y * width + x;
      if (!this.pictures.mask[i]) { output.textContent = `pixel ${x}, ${y}: not compared`; return; }
      const truth = this.pictures.truth[this.truth][i];
      const parts = [`pixel ${x}, ${y}`, `truth <b>${truth.toFixed(4)}</b>`];
      for (const source of new Set([this.left, this.right])) {
        if (source === REFERENCE) continue;
        const value = this.pictures.values(source, this.truth)[i], error = value - truth;
        parts.push(`${escape(this.name(source))} <b>${value.toFixed(4)}</b> (${error < 0 ? "−" : "+"}${Math.abs(error).toFixed(4)})`);
      }
      output.innerHTML = parts.join(" · ");
    }

    draw() {
      this.control("left").value = this.left;
      this.control("right").value = this.right;
      $(this.root, ".tag-left").textContent = this.name(this.left);
      $(this.root, ".tag-right").textContent = this.name(this.right);
      this.drawLegend();
      this.drawStrip();
      this.paint();
    }

    drawLegend() {
      const legend = $(this.root, ".legend"), signed = this.mode === "signed";
      legend.hidden = this.mode === "shaded" || this.mode === "visibility";
      if (legend.hidden) return;
      $(legend, ".legend-title").textContent = signed ? "V − truth" : "|V − truth|";
      $(legend, ".legend-low").textContent = signed ? `too dark −${this.scale}` : "0";
      $(legend, ".legend-high").textContent = signed ? `+${this.scale} too bright` : `${this.scale}${this.scale < 1 ? " or more" : ""}`;
      const context = $(legend, "canvas").getContext("2d"), image = context.createImageData(256, 1), table = signed ? SIGNED : INFERNO;
      for (let i = 0; i < 256; i++) image.data.set([table[3 * i], table[3 * i + 1], table[3 * i + 2], 255], 4 * i);
      context.putImageData(image, 0, 0);
    }

    paint() {
      const { width, height } = this.canvas, [x, y] = this.window(), cut = Math.round(this.split * width);
      const w = width / this.zoom, h = height / this.zoom;
      this.context.imageSmoothingEnabled = false;
      for (const [source, from, to] of [[this.left, 0, cut], [this.right, cut, width]]) {
        if (to <= from) continue;
        const picture = this.pictures.picture(source, this.mode, this.truth, this.scale);
        this.context.drawImage(picture, x * width + from / this.zoom, y * height, (to - from) / this.zoom, h, from, 0, to - from, height);
      }
      this.wipe.style.left = `${100 * this.split}%`;
      this.wipe.setAttribute("aria-valuenow", Math.round(100 * this.split));
    }
  }

  /* ---- plot ---------------------------------------------------------------------------------------------------------- */

  const headline = (record, against) => record.area.penumbra_pixels ? record[against].penumbra_rmse : record[against].rmse;
  const errorOf = (record, metric) => {
    if (metric === "flip") return record.flip;
    const [against, name] = metric.split(".");
    return name === "headline" ? headline(record, against) : record[against][name];
  };
  const SHAPES = [
    r => `<circle r="${r}"/>`, r => `<path d="M${-r * .9} ${-r * .9}h${r * 1.8}v${r * 1.8}h${-r * 1.8}z"/>`,
    r => `<path d="M0 ${-r * 1.25}L${r * 1.25} 0L0 ${r * 1.25}L${-r * 1.25} 0z"/>`, r => `<path d="M0 ${-r * 1.2}L${r * 1.15} ${r * .85}H${-r * 1.15}z"/>`,
    r => `<path d="M0 ${r * 1.2}L${r * 1.15} ${-r * .85}H${-r * 1.15}z"/>`,
    r => `<path d="M${-r * .4} ${-r * 1.2}h${r * .8}v${r * .8}h${r * .8}v${r * .8}h${-r * .8}v${r * .8}h${-r * .8}v${-r * .8}h${-r * .8}v${-r * .8}h${r * .8}z"/>`,
  ];
  const tip = $(document, ".tip");
  const showTip = (html, x, y) => {
    tip.innerHTML = html;
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.min(innerWidth - box.width - 8, x + 14)}px`;
    tip.style.top = `${y + 18 + box.height > innerHeight ? y - box.height - 12 : y + 18}px`;
  };

  class Plot {
    constructor(article, light, viewer) {
      this.article = article;
      this.light = light;
      this.viewer = viewer;
      this.host = $(article, ".plot");
      this.hidden = new Set();
      this.steps = light.records.some(record => record.sweep);
      $(article, ".plot-controls").hidden = false;
      for (const select of $$(article, ".plot-controls select")) select.addEventListener("change", () => this.draw());
      this.draw();
    }

    points() {
      const time = $(this.article, "[data-control=time]").value, metric = $(this.article, "[data-control=metric]").value;
      return this.light.records.filter(record => record.time[time]).map(record => ({
        record, time: Math.max(record.time[time].median, 1e-4), low: Math.max(record.time[time].low, 1e-4),
        high: record.time[time].high, runs: record.time[time].runs, error: errorOf(record, metric), metric,
      })).filter(point => Number.isFinite(point.error));
    }

    draw() {
      const all = this.points();
      if (!all.length) { this.host.innerHTML = "<p class=hint>Nothing was measured at this light.</p>"; return; }
      const visible = all.filter(point => !this.hidden.has(point.record.technique));
      const W = 640, H = 400, left = 64, right = W - 14, top = 12, bottom = H - 46;
      const positive = all.map(point => point.error).filter(error => error > 0);
      const floor = Math.min(...positive, 0.01) / 2;
      const at = error => Math.max(error, floor);
      const noise = this.light.noise, errors = all.map(point => at(point.error));
      if (noise > floor / 20 && visible[0]?.metric !== "flip") errors.push(noise);
      const range = (values, pad) => {
        const low = Math.log10(Math.min(...values)), high = Math.log10(Math.max(...values));
        const room = Math.max((high - low) * pad, 0.12);
        return [low - room, high + room];
      };
      const [x0, x1] = range(all.flatMap(point => [point.low, point.high]), 0.06), [y0, y1] = range(errors, 0.08);
      const X = time => left + (Math.log10(time) - x0) / (x1 - x0) * (right - left);
      const Y = error => bottom - (Math.log10(error) - y0) / (y1 - y0) * (bottom - top);
      const out = [`<svg viewBox="0 0 ${W} ${H}" role="group" aria-label="Error against time, both on logarithmic axes">`];
      out.push(this.axis(x0, x1, value => [X(value), top, X(value), bottom], value => [X(value), bottom + 18, "middle"], value => value >= 1000 ? `${value / 1000} s` : `${Number(value.toPrecision(2))}`));
      out.push(this.axis(y0, y1, value => [left, Y(value), right, Y(value)], value => [left - 8, Y(value) + 4, "end"], value => `${Number(value.toPrecision(2))}`));
      out.push(`<rect class="frame" x="${left}" y="${top}" width="${right - left}" height="${bottom - top}"/>`);
      out.push(`<text class="axis-title" x="${(left + right) / 2}" y="${H - 6}" text-anchor="middle">milliseconds</text>`);
      const metricName = $(this.article, "[data-control=metric]").selectedOptions[0].text;
      out.push(`<text class="axis-title" transform="translate(14 ${(top + bottom) / 2}) rotate(-90)" text-anchor="middle">${escape(metricName)}</text>`);
      if (noise > 0 && visible[0]?.metric !== "flip" && Y(noise) < bottom) out.push(`<line class="noise-line" x1="${left}" x2="${right}" y1="${Y(noise)}" y2="${Y(noise)}"/><text class="noise-name" x="${right - 6}" y="${Y(noise) + 14}" text-anchor="end">the reference's own noise</text>`);
      const front = this.front(visible);
      if (front.length) {
        let path = `M${X(front[0].time)} ${top}V${Y(at(front[0].error))}`;
        for (const point of front.slice(1)) path += `H${X(point.time)}V${Y(at(point.error))}`;
        const clip = `clip-${this.light.key}`;
        out.push(`<clipPath id="${clip}"><rect x="${left}" y="${top}" width="${right - left}" height="${bottom - top}"/></clipPath>`);
        out.push(`<path class="front-line" clip-path="url(#${clip})" d="${path}H${right}"/>`);
      }
      const target = page.target;
      if (target && Y(target) > top && Y(target) < bottom && visible[0]?.metric.endsWith("headline")) out.push(`<line class="target-line" x1="${left}" x2="${right}" y1="${Y(target)}" y2="${Y(target)}"/><text class="noise-name" x="${right - 6}" y="${Y(target) - 5}" text-anchor="end">target</text>`);
      for (const line of this.lines(visible)) {
        out.push(`<polyline fill="none" stroke="${line[0].record.colour}" stroke-width="1.6" points="${line.map(point => `${X(point.time)},${Y(at(point.error))}`).join(" ")}"/>`);
      }
      for (const point of visible) {
        const y = Y(at(point.error)), colour = point.record.colour;
        if (X(point.high) - X(point.low) > 3) out.push(`<path stroke="${colour}" stroke-width="1.3" fill="none" d="M${X(point.low)} ${y}H${X(point.high)}M${X(point.low)} ${y - 4}v8M${X(point.high)} ${y - 4}v8"/>`);
      }
      const curve = new Set(this.lines(visible).flat());
      visible.forEach((point, i) => {
        const { record } = point, big = !record.sweep;
        const shape = SHAPES[record.marker % SHAPES.length](big ? 6.5 : 4);
        out.push(`<g class="point${curve.has(point) ? "" : " beside"}" tabindex="${big ? 0 : -1}" role="button" data-point="${i}" transform="translate(${X(point.time)} ${Y(at(point.error))})" fill="${record.colour}" stroke="var(--sheet)" stroke-width="1.2" aria-label="${escape(record.label)}: error ${figure(point.error)}, ${ms(point.time)}">${shape}</g>`);
      });
      out.push("</svg>", this.keys(all));
      this.host.innerHTML = out.join("");
      this.listen(visible, new Set(front));
    }

    axis(low, high, line, label, name) {
      const out = [], wide = high - low > 1.3;
      for (let power = Math.floor(low); power <= Math.ceil(high); power++) {
        for (let digit = 1; digit < 10; digit++) {
          const value = digit * 10 ** power, place = Math.log10(value);
          if (place < low || place > high) continue;
          const named = digit === 1 || digit === 2 && high - low < 3.2 || digit === 5 && high - low < 3.2 || !wide && digit % 2 === 0 || high - low < 0.7;
          const [xa, ya, xb, yb] = line(value);
          out.push(`<line class="${digit === 1 ? "grid" : "minor"}" x1="${xa}" y1="${ya}" x2="${xb}" y2="${yb}"/>`);
          if (named) { const [x, y, anchor] = label(value); out.push(`<text x="${x}" y="${y}" text-anchor="${anchor}">${name(value)}</text>`); }
        }
      }
      return out.join("");
    }

    /** A technique's line is its own front. */
    lines(points) {
      const techniques = [...new Set(points.map(point => point.record.technique))];
      return techniques.map(technique => this.front(points.filter(point => point.record.technique === technique)));
    }

    front(points) {
      const front = [];
      let best = Infinity;
      for (const point of [...points].sort((a, b) => a.time - b.time || a.error - b.error)) {
        if (point.error < best) { front.push(point); best = point.error; }
      }
      return front;
    }

    keys(points) {
      const seen = new Map();
      for (const { record } of points) if (!seen.has(record.technique)) seen.set(record.technique, record);
      return `<div class="keys">${[...seen.values()].map(record => `<button type="button" aria-pressed="${!this.hidden.has(record.technique)}" data-technique="${escape(record.technique)}" title="Show or hide"><svg viewBox="-9 -9 18 18" fill="${record.colour}" aria-hidden="true">${SHAPES[record.marker % SHAPES.length](6.5)}</svg>${escape(record.title)}</button>`).join("")}</div>`;
    }

    listen(points, front) {
      for (const mark of $$(this.host, ".point")) {
        const point = points[mark.dataset.point], { record } = point;
        const text = `<b>${escape(record.label)}</b><br>error ${figure(point.error)}<br>${ms(point.time)} (95 %: ${ms(point.low)} to ${ms(point.high)}, ${point.runs} runs)${front.has(point) ? "<br>on the Pareto front" : ""}${record.settings ? `<br><small>${escape(record.settings)}</small>` : ""}`;
        mark.addEventListener("pointermove", event => showTip(text, event.clientX, event.clientY));
        mark.addEventListener("pointerleave", () => { tip.hidden = true; });
        mark.addEventListener("focus", () => { const box = mark.getBoundingClientRect(); showTip(text, box.right, box.top); });
        mark.addEventListener("blur", () => { tip.hidden = true; });
        const choose = () => { if (record.picture && this.viewer) this.viewer.choose("right", record.index); };
        mark.addEventListener("click", choose);
        mark.addEventListener("keydown", event => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); choose(); } });
      }
      for (const button of $$(this.host, ".keys button")) {
        button.addEventListener("click", () => {
          const id = button.dataset.technique;
          if (!this.hidden.delete(id)) this.hidden.add(id);
          this.draw();
          $(this.host, `.keys [data-technique="${id}"]`)?.focus();
        });
      }
    }
  }

  /* ---- table ---------------------------------------------------------------------------------------------------------- */

  function tableOf(article, viewer) {
    const table = $(article, ".table-box table");
    if (!table) return;
    const body = $(table, "tbody");
    $$(table, "thead th").forEach((head, column) => {
      head.innerHTML = `<button type="button">${head.innerHTML}</button>`;
      $(head, "button").addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        for (const other of $$(table, "thead th")) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        const value = row => row.children[column]?.dataset.value ?? "";
        const number = head.dataset.sort === "number";
        const rows = $$(body, "tr[data-record]").sort((a, b) => number ? Number(value(a)) - Number(value(b)) : value(a).localeCompare(value(b)));
        if (down) rows.reverse();
        body.prepend(...rows);
      });
    });
    for (const row of $$(body, "tr[data-record]")) {
      const index = Number(row.dataset.record);
      row.addEventListener("click", () => { if (viewer?.shown.some(record => record.index === index)) viewer.choose("right", index); });
    }
    const toggle = $(article, "[data-control=steps]");
    if (toggle) {
      toggle.closest("label").hidden = false;
      toggle.addEventListener("change", () => table.classList.toggle("with-steps", toggle.checked));
    }
  }

  /* ---- start: each light when it comes near, all before printing -------------------------------------------------------- */

  const waiting = new Map();
  const start = article => { const go = waiting.get(article); waiting.delete(article); return go?.(); };
  const watcher = new IntersectionObserver(entries => {
    for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); start(entry.target); }
  }, { rootMargin: "800px" });
  for (const article of $$(document, "article.light")) {
    const light = page.lights.find(entry => entry.key === article.dataset.light);
    const viewer = light.area && $(article, ".viewer") ? new Viewer(article, light) : null;
    tableOf(article, viewer);
    if ($(article, ".plot")) new Plot(article, light, viewer);
    if (viewer) {
      waiting.set(article, () => viewer.start().catch(error => {
        $(article, ".viewer").insertAdjacentHTML("afterend", `<p class="caution bad">This browser could not show the pictures (${escape(error.message)}); they lie beside this page as files.</p>`);
      }));
      watcher.observe(article);
    }
  }
  const first = $$(document, "article.light").find(article => waiting.has(article));
  if (first) start(first);
  addEventListener("beforeprint", () => { for (const article of [...waiting.keys()]) start(article); });
})();
