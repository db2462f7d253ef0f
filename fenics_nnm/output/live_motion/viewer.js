"use strict";
/* The motion of the body, to turn and to play. vtk.js draws it; where there is no WebGL the figure
   stays hidden, and the pictures below it are all that there is. */
(() => {
  const at = (id) => document.getElementById(`live-${id}`);
  const figure = at("figure"), stage = at("stage"), play = at("play");
  const webgl = document.createElement("canvas").getContext("webgl2");
  if (!webgl || !("DecompressionStream" in window)) return;
  webgl.getExtension("WEBGL_lose_context")?.loseContext();
  figure.hidden = false;

  const bytes = (letters) => Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
  const floats = (letters) => new Float32Array(bytes(letters).buffer);
  const motion = JSON.parse(at("motion").textContent);
  const rest = floats(motion.places), shapes = new Int16Array(bytes(motion.shapes).buffer);
  const pressed = bytes(motion.pressed), colours = bytes(motion.colours);
  const sheets = motion.sheets.map((sheet) =>
    ({ places: floats(sheet.places), gaps: floats(sheet.gaps) }));
  const count = rest.length / 3, body = motion.surface, contacts = count - body;
  const row = Math.ceil(contacts / 8);
  const touched = motion.touched, apart = motion.apart;

  let phase = motion.start, factor = motion.factor, playing = false, view = null;

  /* Displacements of all nodes at a part of the period: shapes times their Fourier series. */
  function displacements() {
    const moved = new Float32Array(rest.length);
    motion.scale.forEach((scale, shape) => {
      let course = 0;
      for (let n = 0; n < motion.cos.length; n++) {
        const angle = 2 * Math.PI * n * phase;
        course += motion.cos[n][shape] * Math.cos(angle) + motion.sin[n][shape] * Math.sin(angle);
      }
      const size = course * scale, first = shape * rest.length;
      for (let k = 0; k < rest.length; k++) moved[k] += size * shapes[first + k];
    });
    return moved;
  }

  function isPressed(contact) {
    const instant = Math.round(phase * motion.instants) % motion.instants;
    return (pressed[instant * row + (contact >> 3)] >> (7 - (contact & 7))) & 1;
  }

  function put(part, places, tints) {
    part.getPoints().setData(places, 3);
    part.getPoints().modified();
    if (tints) {
      part.getPointData().getScalars().setData(tints, 3);
      part.getPointData().modified();
    }
    part.modified();
  }

  function draw() {
    const moved = displacements(), places = rest.map((x, k) => x + factor * moved[k]);
    const tints = new Uint8Array(3 * body), dots = new Uint8Array(3 * contacts);
    const steps = colours.length / 3 - 1;
    for (let node = 0; node < body; node++) {
      const length = Math.hypot(moved[3 * node], moved[3 * node + 1], moved[3 * node + 2]);
      const step = 3 * Math.min(steps, Math.round(steps * length / motion.largest));
      tints.set(colours.subarray(step, step + 3), 3 * node);
    }
    for (let n = 0; n < contacts; n++) dots.set(isPressed(n) ? touched : apart, 3 * n);
    put(view.parts[0], places.slice(0, 3 * body), tints);
    put(view.parts[2], places.slice(3 * body), dots);
    sheets.forEach((sheet, n) =>
      put(view.parts[3 + n], sheet.places.map((x, k) => x + factor * sheet.gaps[k])));
    at("time").value = phase;
    at("instant").value = phase.toFixed(2);
    at("factor").value = Math.log10(factor / motion.factor);
    at("times").value = `${factor.toPrecision(2) * 1} times`;
    view.renderer.resetCameraClippingRange();
    view.window.render();
  }

  let before = 0;
  function frame(now) {
    if (!playing) return;
    phase = (phase + Math.min(now - before, 100) / motion.milliseconds) % 1;
    before = now;
    draw();
    requestAnimationFrame(frame);
  }

  function setPlaying(wanted) {
    playing = wanted;
    play.textContent = playing ? "Pause" : "Play";
    before = performance.now();
    if (playing) requestAnimationFrame(frame);
  }

  function setView() {
    const camera = view.renderer.getActiveCamera();
    camera.setParallelProjection(true);
    camera.setFocalPoint(...motion.middle);
    camera.setPosition(...motion.middle.map((x, k) => x + motion.away * motion.towards[k]));
    camera.setViewUp(...motion.up);
    const [across, upwards] = motion.half;
    camera.setParallelScale(Math.max(upwards, across * stage.clientHeight / stage.clientWidth));
    draw();
  }

  function turn(act) {
    const camera = view.renderer.getActiveCamera();
    act(camera);
    camera.orthogonalizeViewUp();
    draw();
  }

  const keys = {
    " ": () => setPlaying(!playing),
    ArrowLeft: () => turn((camera) => camera.azimuth(10)),
    ArrowRight: () => turn((camera) => camera.azimuth(-10)),
    ArrowUp: () => turn((camera) => camera.elevation(-10)),
    ArrowDown: () => turn((camera) => camera.elevation(10)),
    "+": () => turn((camera) => camera.zoom(1.2)),
    "-": () => turn((camera) => camera.zoom(1 / 1.2)),
    Home: setView,
  };

  function listen() {
    play.addEventListener("click", () => setPlaying(!playing));
    at("home").addEventListener("click", setView);
    at("time").addEventListener("input", (event) => {
      setPlaying(false);
      phase = event.target.value % 1;
      draw();
    });
    at("factor").addEventListener("input", (event) => {
      factor = motion.factor * 10 ** event.target.value;
      draw();
    });
    stage.addEventListener("keydown", (event) => {
      const act = event.ctrlKey || event.altKey || event.metaKey ? undefined : keys[event.key];
      if (act) {
        event.preventDefault();
        act();
      }
    });
    /* The wheel scrolls the page until the body was clicked, or reached with the keyboard. */
    stage.addEventListener("wheel", (event) => {
      if (!stage.contains(document.activeElement)) event.stopPropagation();
    }, { capture: true });
    stage.addEventListener("pointerdown", () => stage.focus({ preventScroll: true }));
    new IntersectionObserver((seen) => {
      if (!seen.at(-1).isIntersecting) setPlaying(false);
    }).observe(stage);
  }

  /* The scene is read from its file in steps: its parts are there some frames later. */
  function begin() {
    const scene = window.global.renderWindow;
    const renderer = scene.getRenderers().find((each) => each.getActors().length);
    if (!renderer || renderer.getActors().length < 3 + sheets.length) {
      requestAnimationFrame(begin);
      return;
    }
    const parts = renderer.getActors().map((actor) => actor.getMapper().getInputData());
    if (parts.some((part) => !part || !part.getNumberOfPoints())) {
      requestAnimationFrame(begin);
      return;
    }
    view = { window: scene, renderer, parts };
    setView();
    listen();
    figure.dataset.ready = "yes";
  }

  async function load() {
    const packed = new Blob([bytes(at("library").textContent)]).stream();
    const text = await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).text();
    window.global = window.global || {};
    window.loadDataSet = () => {
      window.OfflineLocalView.load(stage, { base64Str: at("scene").textContent });
      begin();
    };
    const script = document.createElement("script");
    script.type = "module";
    script.textContent = text;
    document.head.append(script);
  }

  new IntersectionObserver((seen, observer) => {
    if (seen.at(-1).isIntersecting) {
      observer.disconnect();
      load();
    }
  }, { rootMargin: "300px" }).observe(stage);
})();
