// Saving from the page: picture, jobs, address.

import { captionOf, fileOfStarts, gridOfStarts, jobText, npyOf, offerFile, pictureOf, planeOfStarts } from "./saving.js";
import { systemOf } from "./state.js";

export function makeSaving(app, { notice, sceneOf, redraw, addressOf }) {
  const { orbits, section, setup, part } = app;
  const stem = (system) => system.name.replace(/[^A-Za-z0-9_-]+/g, "-");

  // The lines of [initial_conditions] and the files beside the job.
  function saveJob(suffix, starts) {
    const system = systemOf(setup, app.state);
    if (system.line) return notice("A job has no plane of a map of one variable. Copy the address of this state instead.", true);
    const name = stem(system) + suffix;
    const text = jobText(app.state, system, starts(name));
    if (text === null) return notice("A job file cannot describe this system: it was made in Python, or its equations are driven.", true);
    offerFile(name + ".toml", [text], "application/toml");
    return notice("Saved " + name + ".toml; run it with: fastaff run " + name + ".toml");
  }

  return {
    async "save-picture"() {
      const system = systemOf(setup, app.state);
      const blob = await pictureOf(section, sceneOf(app), system.title, captionOf(app.state, system));
      redraw("section");
      offerFile(stem(system) + ".png", [blob], "image/png");
    },
    "save-job"() {
      const isDriven = app.root.hasAttribute("data-driven"), whole = (z) => (isDriven ? [z[0], app.state.phase, z[1], 0] : z);
      const states = [...orbits.shown.values()].filter((orbit) => orbit.z0).map((orbit) => whole(orbit.z0));
      if (!states.length) return notice("There are no orbits to save. Launch some or save a grid over the view.", true);
      return saveJob("", (name) => {
        offerFile(name + ".npy", [npyOf(states)], "application/octet-stream");
        return fileOfStarts(name + ".npy");
      });
    },
    "save-grid": () => app.root.hasAttribute("data-driven") || app.root.dataset.kind === "ode" ? notice("Grids are not supported for driven systems and ODEs. Fill the view and save the job with these orbits.", true) : saveJob("-grid", () => (app.root.dataset.kind === "map" ? planeOfStarts(section.frame.view, Number(part("grid").value), app.state, section.surface.periods) : gridOfStarts(section.frame.view, Number(part("grid").value)))),
    async "copy-address"() {
      const address = location.href.replace(/#.*$/, "") + "#" + addressOf();
      try {
        await navigator.clipboard.writeText(address);
        notice("Address copied.");
      } catch {
        notice("The browser does not allow copying. Copy the address from its address bar.", true);
      }
    },
  };
}
