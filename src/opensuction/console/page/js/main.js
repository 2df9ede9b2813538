// The page begins here.

import { Api } from "./api.js";
import { Live } from "./live.js";
import { Session } from "./session.js";
import { mountShell } from "./shell.js";
import { text } from "./text.js";

const api = new Api(text.shell);
const context = { api, live: new Live(), session: new Session(api), machine: null, text };
mountShell(document.getElementById("console"), document.querySelector(".footer"), context);
