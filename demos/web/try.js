// usage: node try.js PAGE.html PICTURE.png
//
// Opens the page in headless Chromium, which is told what to do through a pipe (its DevTools protocol). Makes 60 steps of
// each scene with softcd's default and safe settings and with Bullet's own contacts, and prints a table of medians. Safe
// settings must leave no crossing edge. Writes a picture of the first scene. Clicks on each detector while the scene
// runs. Pulls its cloth with the mouse and checks that it follows.
'use strict';
const {spawn} = require('child_process');
const fs = require('fs');
const os = require('os');
const path = require('path');

const [pageFile, pictureFile] = process.argv.slice(2);
const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'softcd-web-'));
const chromium = spawn('chromium', [
  '--headless', '--no-sandbox', '--disable-gpu-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--window-size=1000,640', '--hide-scrollbars', '--remote-debugging-pipe', `--user-data-dir=${profile}`, 'about:blank',
], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});

// The page's detectors.
const [kDefault, kSafe, kBullet, kNone] = [0, 1, 2, 3];

const waiting = new Map();
let received = '';
let last = 0;
chromium.stdio[4].on('data', data => {
  const messages = (received + data).split('\0');
  received = messages.pop();
  for (const text of messages) {
    const message = JSON.parse(text);
    const {resolve, reject} = waiting.get(message.id) || {};
    waiting.delete(message.id);
    if (resolve && message.error) reject(new Error(message.error.message));
    if (resolve && !message.error) resolve(message.result);
  }
});

function send(method, params = {}, sessionId) {
  const id = ++last;
  chromium.stdio[3].write(JSON.stringify({id, method, params, sessionId}) + '\0');
  return new Promise((resolve, reject) => waiting.set(id, {resolve, reject}));
}

function check(holds, what) {
  if (!holds) throw new Error(what);
}

async function tryPage() {
  const {targetId} = await send('Target.createTarget', {url: `file://${path.resolve(pageFile)}#paused`});
  const {sessionId} = await send('Target.attachToTarget', {targetId, flatten: true});
  const evaluate = async expression => {
    const {result, exceptionDetails} =
        await send('Runtime.evaluate', {expression, returnByValue: true, awaitPromise: true}, sessionId);
    check(!exceptionDetails, JSON.stringify(exceptionDetails));
    return result.value;
  };
  const mouse = (type, x, y) =>
      send('Input.dispatchMouseEvent', {type, x, y, button: 'left', buttons: 1, clickCount: 1}, sessionId);
  for (let tries = 0; !(await evaluate('typeof page === "object" && "scene_count" in page')); ++tries) {
    const problem = await evaluate('document.body ? element("problem").textContent : ""').catch(() => '');
    check(tries < 600 && !problem, 'the page does not start: ' + problem);
    await new Promise(resolve => setTimeout(resolve, 100));
  }

  console.log('scene triangles | softcd, default: ms a step, contacts, crossing edges | softcd, safe | Bullet');
  const names = await evaluate('Array.from(element("scene").options, option => option.text)');
  for (let scene = 0; scene < names.length; ++scene) {
    const row = [names[scene], await evaluate(`open(${scene}), page.triangles()`)];
    for (const detector of [kDefault, kSafe, kBullet]) {
      const found = await evaluate(`(() => {
        const problem = page.open(${scene}, ${detector}) || page.step();
        if (problem) return {problem};
        const all = [];
        for (let i = 1; i < 60; ++i) {
          const problem = page.step();
          if (problem) return {problem};
          all.push(page.step_ms());
        }
        all.sort((a, b) => a - b);
        return {ms: all[29], contacts: page.contacts(), crossings: page.crossings()};
      })()`);
      check(!found.problem || detector === kBullet, `${names[scene]}: ${found.problem}`);
      check(detector !== kSafe || found.crossings === 0, `${names[scene]}: ${found.crossings} crossing edges`);
      row.push('|', ...(found.problem ? ['refused'] : [found.ms.toFixed(2), found.contacts, found.crossings]));
    }
    console.log(row.join(' '));
  }

  await evaluate('open(0)');
  await evaluate('for (let i = 0; i < 60; ++i) step()');
  const {data} = await send('Page.captureScreenshot', {format: 'png'}, sessionId);
  fs.writeFileSync(pictureFile, Buffer.from(data, 'base64'));

  // The same scene goes on with each detector.
  for (const detector of [kBullet, kNone, kSafe, kDefault]) {
    const problem = await evaluate(
        `document.querySelector('[name=detector][value="${detector}"]').click(), step(), element("problem").textContent`);
    check(!problem, `detector ${detector}: ${problem}`);
    const contacts = await evaluate('page.contacts()');
    check((contacts > 0) === (detector !== kNone), `detector ${detector}: ${contacts} contacts`);
  }

  // The same steps with and without the mouse, which pulls the cloth upwards.
  const nodes = 'Array.from(new Float32Array(Module.HEAPF32.buffer, page.vertices(), 6 * page.vertex_count()))';
  const prepare = 'open(0); for (let i = 0; i < 60; ++i) step()';
  const pullSteps = `(() => { for (let i = 0; i < 20; ++i) step(); return ${nodes}; })()`;
  await evaluate(prepare);
  const free = await evaluate(pullSteps);
  await evaluate(prepare);
  await mouse('mousePressed', 500, 136);
  for (let y = 126; y >= 16; y -= 10) await mouse('mouseMoved', 500, y);
  const pulled = await evaluate(pullSteps);
  await mouse('mouseReleased', 500, 16);
  let furthest = 0;
  for (let i = 0; i < free.length; i += 6) {
    furthest = Math.max(furthest, Math.hypot(...[0, 1, 2].map(axis => pulled[i + axis] - free[i + axis])));
  }
  check(furthest > 0.1, `a pulled cloth moves by ${furthest} only`);
  console.log(`a pulled cloth's furthest node is ${furthest.toFixed(2)} away from where it would be`);
}

tryPage().catch(error => {
  console.error(`the page failed: ${error.message}`);
  process.exitCode = 1;
}).finally(() => {
  chromium.once('exit', () => fs.rmSync(profile, {recursive: true, force: true}));
  chromium.kill();
});
