// The page as a file of its own: its set-up, a worker made of its text, the explorer.

import { startExplorer } from "./app.js";
import { workerBackend } from "./backend.js";

const setup = JSON.parse(document.getElementById("setup").textContent);
startExplorer(document.querySelector(".explorer"), setup, workerBackend(setup), { standalone: true });
