// Tests the page in a real browser: node test.mjs [NAME...], for scripts/test-web.
// What is judged are pixels and the values that the page tells, never numbers of frames.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { deflateRawSync } from 'node:zlib';
import { PNG } from 'pngjs';
import { browser, Tab } from './browser.mjs';
import { serve } from './server.mjs';

const ROOT = join(import.meta.dirname, '../..');
const SANDBOX = process.env.SANDBOX ?? join(ROOT, 'target/release/sandbox');
const OUT = join(ROOT, 'target/test-web');
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, deviceScaleFactor: 2 };
const site = await serve(join(ROOT, 'target/web'));
const play = link => `${site.address}play.html#${link}`;
const native = (...args) => execFileSync(SANDBOX, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
const packed = text => deflateRawSync(text).toString('base64url');
const folder = () => mkdtempSync(join(tmpdir(), 'inertia-'));

// Runs `test` with a tab of a browser of its own.
async function withTab(link, options, test) {
    const { context, close } = await browser(options);
    try {
        const tab = await Tab.open(context, play(link));
        await test(tab, context);
        assert.deepEqual(tab.said, [], 'messages in the console');
    } finally {
        await close();
    }
}

const pixel = async (tab, body) => {
    const scale = await tab.tab.evaluate(() => devicePixelRatio);
    const place = await tab.tab.evaluate(name => [...globalThis.inertia.page.pixel_of(name) ?? []], body);
    return place.map(side => side / scale);
};
const click = async (tab, body, button = 'left') => tab.tab.mouse.click(...await pixel(tab, body), { button, delay: 60 });
// A scene that has just opened is framed in the next frames.
const settled = tab => tab.tab.waitForTimeout(1200);
const at = (name, step) => state => state.lesson?.[0] === name && state.lesson[1] === step;

// The number of colors of what the canvas shows.
async function colors(tab) {
    const { data } = PNG.sync.read(await tab.tab.screenshot());
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
    return seen.size;
}

const tests = {
    async 'a scene is selected, pushed, switched and left'() {
        await withTab('webgl', {}, async tab => {
            assert.ok(await colors(tab) > 1000);
            await click(tab, 'grid.x0.z4');
            await tab.until(state => state.selection === 'grid.x0.z4');
            const before = (await tab.state()).hash;
            await click(tab, 'grid.x0.z4', 'right');
            await tab.until(state => state.hash !== before && state.speed > 0.1);
            await tab.tab.keyboard.press('g', { delay: 60 });
            await tab.until(state => state.gravity);
            await tab.tab.keyboard.press('q', { delay: 60 });
            await tab.until(state => state.camera_mode);
            await tab.tab.keyboard.press('q', { delay: 60 });
            await tab.until(state => !state.camera_mode);
        });
    },

    async 'the first lesson is played by mouse'() {
        await withTab('webgl', {}, async tab => {
            await tab.click('Start the first lesson (2 min)');
            await tab.until(at('force', 0));
            await settled(tab);
            await click(tab, 'grid.x0.z4');
            await tab.until(at('force', 1));
            await click(tab, 'grid.x0.z4', 'right');
            await tab.until(at('force', 2));
            await tab.tab.mouse.move(...await pixel(tab, 'grid.x0.z4'));
            await tab.until(state => Math.abs(state.speed) < 0.05);
            for (let notch = 0; notch < 2; notch += 1) await tab.tab.mouse.wheel(0, -120);
            await tab.until(state => state.click_force === 210);
            await click(tab, 'grid.x0.z4', 'right');
            await tab.until(at('force', 3));
            await tab.click('answer', 'TextInput');
            await tab.until(state => state.takes_text);
            await tab.tab.keyboard.type('5', { delay: 60 });
            await tab.click('Answer');
            await tab.until(at('force', 4));
            // Progress is kept.
            await tab.tab.reload();
            await tab.started();
            await tab.click('Learn');
            await tab.control('✔ What a force does');
        });
    },

    async 'the second lesson is played by touch'() {
        await withTab('webgl&lesson=mass', { ...PHONE, viewport: { width: 820, height: 1180 } }, async tab => {
            const tap = async body => await settled(tab) ?? tab.tab.touchscreen.tap(...await pixel(tab, body));
            const hold = async body => {
                const [x, y] = await pixel(tab, body);
                const session = await tab.tab.context().newCDPSession(tab.tab);
                await session.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x, y }] });
                await tab.tab.waitForTimeout(1200);
                await session.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
            };
            await tab.until(at('mass', 0));
            await settled(tab);
            await tap('player');
            await tab.until(state => state.selection === 'player');
            await hold('player');
            await tab.until(at('mass', 1));
            await tap('grid.x0.z4');
            await tab.until(state => state.selection === 'grid.x0.z4');
            await hold('grid.x0.z4');
            await tab.until(at('mass', 2));
            await tap('player');
            await tab.until(state => state.selection === 'player');
            for (let notch = 0; notch < 2; notch += 1) await tab.tap('More force');
            await tab.until(state => state.click_force === 210);
            await hold('player');
            await tab.until(at('mass', 3));
            await settled(tab);
            await tab.tap('It stays where it is');
            await tab.until(at('mass', 4));
            await tab.tap('answer', 'TextInput');
            await tab.until(state => state.takes_text);
            await tab.tab.keyboard.type('100', { delay: 60 });
            await tab.tap('Answer');
            await tab.until(at('mass', 5));
        });
    },

    async 'a finger drags a ball, and rests on it to push it'() {
        await withTab('webgl&scene=tutorial', PHONE, async tab => {
            await settled(tab);
            const session = await tab.tab.context().newCDPSession(tab.tab);
            const touch = (type, ...touchPoints) => session.send('Input.dispatchTouchEvent', { type, touchPoints });
            const [x, y] = await pixel(tab, 'grid.x0.z4');
            const { hash } = await tab.state();
            await touch('touchStart', { x, y });
            for (let i = 1; i <= 12; i += 1) {
                await touch('touchMove', { x: x - 6 * i, y: y - 3 * i });
                await tab.tab.waitForTimeout(60);
            }
            await tab.until(state => state.selection === 'grid.x0.z4' && state.speed > 0.1 && state.hash !== hash);
            await touch('touchEnd');
        });
    },

    async 'what is changed is kept, offered, saved, dropped and linked'() {
        await withTab('webgl&scene=oscillator', {}, async (tab, context) => {
            const save = async () => {
                const [file] = await Promise.all([tab.tab.waitForEvent('download'), tab.tab.keyboard.press('Control+Shift+S', { delay: 60 })]);
                return [file.suggestedFilename(), readFileSync(await file.path(), 'utf8')];
            };
            for (const key of ['m', 'k', 'Control+d']) await tab.tab.keyboard.press(key, { delay: 60 });
            await tab.until(state => state.unsaved);
            await tab.tab.reload();
            await tab.started();
            await tab.until(state => state.asks);
            await tab.click('Open them');
            await tab.until(state => state.unsaved && !state.asks);
            const [name, text] = await save();
            assert.match(name, /\.ron$/);
            await tab.until(state => !state.unsaved);
            // Dropped into another tab, and as a link.
            for (const link of [undefined, `scene=${packed(text)}`]) {
                const other = await Tab.open(context, play(`webgl&${link ?? 'scene=orbit'}`));
                if (!link) {
                    await other.tab.setInputFiles('#files', { name: 'mine.ron', mimeType: '', buffer: Buffer.from(text) });
                }
                const bodies = await tab.state();
                await other.until(state => state.bodies === bodies.bodies, 'the bodies of the scene');
                await other.tab.close();
            }
        });
    },

    async 'text is pasted, composed by an input method, and copied'() {
        await withTab('webgl&scene=orbit', { permissions: ['clipboard-read', 'clipboard-write'] }, async tab => {
            const { keyboard } = tab.tab;
            const find = async () => {
                await keyboard.press('Control+o', { delay: 60 });
                await tab.until(state => state.takes_text);
            };
            const clipboard = () => tab.tab.evaluate(() => navigator.clipboard.readText());
            await tab.tab.evaluate(() => navigator.clipboard.writeText('oscill'));
            await find();
            await keyboard.press('Control+v', { delay: 60 });
            await tab.tab.waitForTimeout(500);
            await tab.tab.evaluate(() => navigator.clipboard.writeText('nothing'));
            await keyboard.press('Control+a', { delay: 60 });
            await keyboard.press('Control+c', { delay: 60 });
            await tab.tab.waitForFunction(async () => await navigator.clipboard.readText() === 'oscill');
            await keyboard.press('Control+x', { delay: 60 });
            await tab.tab.waitForTimeout(500);
            await keyboard.press('Control+v', { delay: 60 });
            await keyboard.press('Enter', { delay: 60 });
            await tab.until(state => state.scene === 'oscillator');
            assert.equal(await clipboard(), 'oscill');
            const session = await tab.tab.context().newCDPSession(tab.tab);
            await find();
            for (const text of ['b', 'br', 'bri']) {
                await session.send('Input.imeSetComposition', { text, selectionStart: text.length, selectionEnd: text.length });
                await tab.tab.waitForTimeout(200);
            }
            await session.send('Input.insertText', { text: 'bridge' });
            await keyboard.press('Enter', { delay: 60 });
            await tab.until(state => state.scene === 'bridge');
        });
    },

    async 'a lesson is opened with its scene, and samples are saved as a table'() {
        const scene = readFileSync(join(ROOT, 'crates/scene/assets/scenes/oscillator.ron'), 'utf8')
            .replace('name: "oscillator"', 'name: "own"');
        const guide = readFileSync(join(ROOT, 'docs/lessons.md'), 'utf8');
        const lesson = /```ron\n([^`]*steps:[^`]*)```/.exec(guide)[1].replace('scene: "oscillator"', 'scene: "own.ron"');
        await withTab('webgl&scene=orbit', {}, async tab => {
            const file = (name, text) => ({ name, mimeType: '', buffer: Buffer.from(text) });
            await tab.tab.setInputFiles('#files', [file('first.ron', lesson), file('own.ron', scene)]);
            await tab.until(at('first.ron', 0));
            assert.equal((await tab.state()).scene, 'own');
            await tab.tab.keyboard.press('y', { delay: 60 });
            await tab.tab.keyboard.press('k', { delay: 60 });
            const ticks = (await tab.state()).ticks;
            await tab.until(state => state.ticks > ticks + 60);
            const [table] = await Promise.all([tab.tab.waitForEvent('download'), tab.click('Save CSV')]);
            assert.equal(table.suggestedFilename(), 'graph_001.csv');
            const [head, ...rows] = readFileSync(await table.path(), 'utf8').trim().split(/\r?\n/);
            assert.match(head, /^time_s,position_x_m,/);
            // A sample per frame.
            assert.ok(rows.length > 5 && rows.every(row => row.split(',').length === head.split(',').length));
        });
    },

    async 'two tabs keep their own changes'() {
        await withTab('webgl&scene=oscillator', {}, async (one, context) => {
            // The second tab has the editor open, as the first left it.
            const change = async (tab, keys) => {
                for (const key of keys) await tab.tab.keyboard.press(key, { delay: 60 });
                return tab.until(state => state.unsaved);
            };
            await change(one, ['m', 'k', 'Control+d']);
            const other = await Tab.open(context, play('webgl&scene=orbit'));
            assert.ok(!(await other.state()).asks, 'the changes of an open tab are offered');
            const { bodies } = await change(other, ['k', 'Control+d']);
            await one.tab.close();
            const third = await Tab.open(context, play('webgl&scene=springs'));
            await third.until(state => state.asks);
            await third.click('Open them');
            const opened = await third.until(state => state.unsaved && !state.asks);
            assert.notEqual(opened.bodies, bodies, 'the changes of the tab that was closed are opened');
            assert.ok((await other.state()).unsaved);
        });
    },

    async 'without graphics there is a sentence and a still picture'() {
        const { context, close } = await browser();
        try {
            await context.addInitScript(() => {
                HTMLCanvasElement.prototype.getContext = () => null;
                Object.defineProperty(navigator, 'gpu', { value: undefined });
            });
            const tab = await context.newPage();
            await tab.goto(play('scene=tutorial'));
            await tab.waitForFunction(() => !document.getElementById('still').hidden);
            assert.match(await tab.textContent('#words'), /offers no graphics .*, so there is only a still picture/);
            assert.ok(await tab.evaluate(() => document.getElementById('still').naturalWidth > 100));
            await tab.screenshot({ path: join(OUT, 'no-graphics.png') });
        } finally {
            await close();
        }
    },

    async 'a panic says so, and the changes are offered again'() {
        await withTab('webgl&scene=oscillator', {}, async tab => {
            for (const key of ['m', 'k', 'Control+d']) await tab.tab.keyboard.press(key, { delay: 60 });
            await tab.until(state => state.unsaved);
            await tab.tab.waitForTimeout(500);
            await tab.tab.evaluate(async () => (await import('./pkg/page.js')).panic('of a test')).catch(() => {});
            assert.match(await tab.tab.textContent('#words'), /The program has ended\. Unsaved changes are offered.*of a test/s);
            await tab.tab.screenshot({ path: join(OUT, 'panic.png') });
            tab.said = [];
            await tab.tab.click('#again');
            await tab.started();
            await tab.until(state => state.asks);
        });
    },

    async 'a lost context is replaced, and the run goes on'() {
        await withTab('webgl&scene=springs', {}, async tab => {
            const before = await tab.state();
            const seen = await colors(tab);
            await tab.tab.evaluate(() => {
                const canvas = globalThis.inertia.canvas();
                canvas.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext();
            });
            await tab.tab.waitForFunction(() => globalThis.inertia.losses() === 1);
            const after = await tab.until(state => state.ticks > before.ticks + 60 && state.device);
            assert.equal(after.scene, before.scene);
            await tab.tab.waitForTimeout(1500);
            assert.ok(await colors(tab) > seen / 2, 'the picture is there again, with its letters');
            await tab.tab.screenshot({ path: join(OUT, 'after-loss.png') });
            tab.said = tab.said.filter(line => !/CONTEXT_LOST|context lost/i.test(line));
        });
    },

    async 'a run in the page repeats natively, and a native one in the page'() {
        await withTab('webgl&scene=bridge', {}, async tab => {
            await tab.until(state => state.ticks > 200);
            await tab.tab.keyboard.press('p', { delay: 60 });
            const { ticks, hash } = await tab.until(state => state.paused);
            const [file] = await Promise.all([tab.tab.waitForEvent('download'), tab.tab.keyboard.press('Control+s', { delay: 60 })]);
            const bundle = join(folder(), 'bundle.zip');
            await file.saveAs(bundle);
            const said = native('replay', bundle);
            assert.match(said, new RegExp(`${ticks}.*the same state.*${hash}`, 's'));
        });
        const out = folder();
        writeFileSync(join(out, 'save.ron'), '[(at_tick: 290, do: press("Ctrl+S"))]');
        native('run', 'bridge', '--ticks', '300', '--script', join(out, 'save.ron'), '--frames', join(out, 'frames'),
            '--frame-every', '1000');
        const bundle = join(out, 'frames', readdirSync(join(out, 'frames')).find(name => name.endsWith('.zip')));
        await withTab('webgl&scene=orbit', {}, async tab => {
            await tab.tab.setInputFiles('#files', bundle);
            await tab.until(state => state.scene === 'bridge' && native('replay', bundle).includes(state.hash));
        });
    },

    async 'a picture is that of a run without a window'() {
        // The words about the pause differ, and what moves by a part of a tick.
        for (const [scene, most] of [['tutorial', 0.01], ['third_law', 0.04]]) {
            await withTab(`webgl&bare&scene=${scene}`, {}, async tab => {
                await tab.until(state => state.ticks > 30);
                await tab.tab.keyboard.press('p', { delay: 60 });
                await tab.until(state => state.paused);
                // To the end of a tick: between two of them, a picture is interpolated.
                await tab.tab.keyboard.press('.', { delay: 60 });
                await tab.tab.waitForTimeout(1000);
                const { ticks, step_hz: hz } = await tab.state();
                const [file] = await Promise.all([tab.tab.waitForEvent('download'), tab.tab.keyboard.press('F12', { delay: 60 })]);
                const ours = PNG.sync.read(readFileSync(await file.path()));
                const out = folder();
                native('run', scene, '--ticks', String(ticks), '--fps', String(hz), '--size', `${ours.width}x${ours.height}`,
                    '--frames', out, '--frame-every', String(ticks));
                const theirs = PNG.sync.read(readFileSync(join(out, readdirSync(out).filter(name => name.endsWith('.png')).sort().at(-1))));
                const differs = different(ours, theirs);
                console.log(`  ${scene}: ${(100 * differs).toFixed(2)} % of the pixels differ by more than 8 of 255`);
                writeFileSync(join(OUT, `${scene}-page.png`), PNG.sync.write(ours));
                writeFileSync(join(OUT, `${scene}-native.png`), PNG.sync.write(theirs));
                assert.ok(differs < most, `${differs}`);
            });
        }
    },

    async 'all lessons are checked in the page with the words of the command'() {
        await withTab('webgl', {}, async tab => {
            const names = await tab.tab.evaluate(async () => (await import('./pkg/page.js')).lessons());
            assert.equal(names.length, 12);
            for (const name of names) {
                const ours = await tab.tab.evaluate(async name => (await import('./pkg/page.js')).check_lesson(name), name);
                assert.equal(ours, native('lessons', 'check', name), name);
            }
        });
    },

    async 'every state hash is that of the native program'() {
        await withTab('webgl&scene=orbit', {}, async tab => {
            let found = '';
            for (let scene = 0; ; scene += 1) {
                const lines = await tab.tab.evaluate(async scene => (await import('./pkg/page.js')).hashes_of(scene), scene);
                if (lines === undefined) break;
                found += lines;
            }
            const pins = readFileSync(join(ROOT, 'tests/determinism/methods.txt'), 'utf8');
            assert.equal(found, pins);
            // A pin that is wrong is found.
            assert.notEqual(found, pins.replace(/[0-9a-f]{16}/, '0123456789abcdef'));
            console.log(`  ${pins.trim().split('\n').length} hashes are equal`);
        });
    },

    async 'no scene keeps the page busy for long'() {
        await withTab('webgl', {}, async tab => {
            const names = readFileSync(join(ROOT, 'docs/scenes.md'), 'utf8').matchAll(/^\| `([a-z0-9_]+)`/gm);
            const long = [];
            for (const [, name] of names) {
                const other = await Tab.open(tab.tab.context(), play(`webgl&scene=${name}`));
                // The panels of studies, one after the other.
                for (const key of ['c', 'e', 'y', 'b', 'v', 't']) await other.tab.keyboard.press(key, { delay: 60 });
                const { longest_ms: longest } = await other.until(state => state.frames > 30);
                if (longest > 100) long.push(`${name} ${longest.toFixed(0)} ms`);
                await other.tab.close();
            }
            console.log(`  longer than 100 ms without the picture: ${long.join(', ') || 'none'}`);
        });
    },

    // Nothing is judged: times are those of this machine and this moment.
    async 'a step is timed beside one of the native program'() {
        await withTab('webgl&scene=orbit', {}, async tab => {
            for (const name of ['orbit', 'thousand', 'bridge']) {
                const ours = JSON.parse(await tab.tab.evaluate(async name => (await import('./pkg/page.js')).study_of(name), name));
                const { studies: [theirs] } = JSON.parse(native('cost', name, '--quick', '--seconds', '0.5', '--format', 'json'));
                const ratios = ours.cells.flatMap(cell => {
                    const other = theirs.cells.find(({ method, substeps }) => method === cell.method && substeps === cell.substeps);
                    // A clock of a page may stand still for a block of ticks.
                    return cell.time?.ns_per_body_step > 0 && other?.time ? cell.time.ns_per_body_step / other.time.ns_per_body_step : [];
                }).sort((a, b) => a - b);
                assert.ok(ratios.length > 0, name);
                const at = part => ratios[Math.floor(part * (ratios.length - 1))].toFixed(2);
                console.log(`  ${name}: a step takes ${at(0.5)} times the native one (median of ${ratios.length} settings, ${at(0)} to ${at(1)})`);
            }
        });
    },

    async 'a phone shows the first lesson'() {
        await withTab('webgl&lesson=force', PHONE, async tab => {
            await tab.until(at('force', 0));
            await settled(tab);
            await tab.tab.touchscreen.tap(...await pixel(tab, 'grid.x0.z4'));
            await tab.until(at('force', 1));
            await tab.tab.screenshot({ path: join(OUT, 'phone.png') });
        });
    },

    async 'WebGPU draws, too'() {
        await withTab('', { webgpu: true }, async tab => {
            assert.match(await tab.tab.evaluate(() => document.body.dataset.device), /webgpu/);
            assert.ok(await colors(tab) > 1000);
        });
    },
};

// The part of the pixels whose colors differ by more than 8 of 255.
function different(one, other) {
    let count = 0;
    for (let i = 0; i < one.data.length; i += 4) {
        if ([0, 1, 2].some(k => Math.abs(one.data[i + k] - other.data[i + k]) > 8)) count += 1;
    }
    return count / (one.data.length / 4);
}

mkdirSync(OUT, { recursive: true });
const wanted = process.argv.slice(2);
const failed = [];
for (const [name, test] of Object.entries(tests)) {
    if (wanted.length && !wanted.some(part => name.includes(part))) continue;
    const start = Date.now();
    try {
        await test();
        console.log(`ok    ${name} (${((Date.now() - start) / 1000).toFixed(1)} s)`);
    } catch (error) {
        failed.push(name);
        console.log(`FAILED ${name}\n${error.stack}`);
    }
}
site.close();
if (failed.length) process.exit(1);
