// The browser's side of the sandbox: its events, storage, files and links. The program is pkg/page.js, with pkg/page_bg.wasm.
import init, { Page } from './pkg/page.js';

const KEPT = 'inertia/';
const MOST_LINK = 32768;
const byId = id => document.getElementById(id);
const [stage, words, typing] = ['stage', 'words', 'typing'].map(byId);
const link = () => new URLSearchParams(location.hash.slice(1));
const opened = link();
const wantsWebGl = opened.has('webgl');
let canvas, page, failed, frame = 0, timer = 0, holds = false, takesText = false, losses = 0;

const say = (text, detail = '') => {
    words.hidden = !text;
    words.querySelector('p').textContent = text;
    words.querySelector('small').textContent = detail;
};

// What the program asks for.
const host = {
    is_mac: () => /Mac|iPhone|iPad/.test(navigator.platform),
    get(name) {
        try {
            return localStorage.getItem(KEPT + name) ?? undefined;
        } catch {
            return undefined; // Storage may be forbidden: the page then starts as for the first time.
        }
    },
    set(name, text) {
        try {
            if (text === undefined) localStorage.removeItem(KEPT + name);
            else localStorage.setItem(KEPT + name, text);
        } catch { /* as above */ }
    },
    save(name, bytes) {
        const place = URL.createObjectURL(new Blob([bytes]));
        Object.assign(document.createElement('a'), { href: place, download: name }).click();
        setTimeout(() => URL.revokeObjectURL(place), 10000);
    },
};

globalThis.inertia_failed = why => {
    // What comes after the first reason follows from it.
    if (failed) return;
    failed = true;
    cancelAnimationFrame(frame);
    clearTimeout(timer);
    say('The program has ended. Unsaved changes are offered when the page is loaded again.', why);
    byId('again').hidden = false;
};

// The name of this page's draft, which is locked as long as the page is open, and one whose page is gone.
async function drafts() {
    const own = `draft/${Date.now().toString(36)}${Math.random().toString(36).slice(2, 8)}`;
    navigator.locks?.request(own, () => new Promise(() => {}));
    const held = (await navigator.locks?.query())?.held.map(lock => lock.name) ?? [];
    let kept = [];
    try {
        kept = Object.keys(localStorage);
    } catch { /* none */ }
    const names = kept.filter(name => name.startsWith(`${KEPT}draft/`)).map(name => name.slice(KEPT.length));
    return [own, names.find(name => name !== own && !held.includes(name))];
}

const toBase64Url = bytes => btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
const fromBase64Url = text => Uint8Array.from(atob(text.replaceAll('-', '+').replaceAll('_', '/')), c => c.charCodeAt(0));
const through = async (bytes, stream) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
const packed = async text =>
    toBase64Url(await through(new TextEncoder().encode(text), new CompressionStream('deflate-raw')));
const unpacked = async text =>
    new TextDecoder().decode(await through(fromBase64Url(text), new DecompressionStream('deflate-raw')));

// The scene and the lesson of a link: the name of a shipped scene, or the packed text of one.
async function named(parameters) {
    const scene = parameters.get('scene') ?? undefined;
    const lesson = parameters.get('lesson') ?? undefined;
    if (!scene || /^[a-z][a-z0-9_]{0,39}$/.test(scene)) return [scene, undefined, lesson];
    try {
        return [undefined, await unpacked(scene.slice(0, MOST_LINK)), lesson];
    } catch {
        return [scene.slice(0, 40), undefined, lesson];
    }
}

async function share() {
    const { name, text } = page.shared();
    const scene = name ?? await packed(text);
    const address = `${location.href.split('#')[0]}#scene=${scene}`;
    if (scene.length > MOST_LINK) return note('This scene is too long for a link. Save it (Ctrl+S) and send the file.');
    try {
        await navigator.clipboard.writeText(address);
        note('The link is in the clipboard.');
    } catch {
        prompt('The link:', address);
    }
}

let noted = 0;
const note = text => {
    byId('note').textContent = text;
    clearTimeout(noted);
    noted = setTimeout(() => { byId('note').textContent = ''; }, 6000);
};

const wake = () => {
    if (!frame && page && !failed) frame = requestAnimationFrame(tick);
};

function tick() {
    frame = 0;
    clearTimeout(timer);
    if (failed) return;
    const after = page.frame();
    const { due_s: due, cursor, copied, opens, lost } = after;
    [holds, takesText] = [after.holds_pointer, after.takes_text];
    after.free();
    if (cursor) stage.style.cursor = holds ? 'none' : cursor;
    if (copied !== undefined) navigator.clipboard?.writeText(copied).catch(() => note('The browser does not let this page copy.'));
    if (opens !== undefined) open(opens, '_blank', 'noopener');
    if (holds !== (document.pointerLockElement === stage)) {
        if (holds) hold();
        else document.exitPointerLock();
    }
    if (takesText !== (document.activeElement === typing)) (takesText ? typing : stage).focus({ preventScroll: true });
    if (lost) replaceCanvas();
    if (due < 0.02) wake();
    else if (due < 1e6) timer = setTimeout(wake, 1000 * due);
}

// A browser refuses this until the person has clicked; motion then counts as it is.
const hold = () => stage.requestPointerLock?.()?.catch?.(() => {});

function resize() {
    const scale = devicePixelRatio || 1;
    const { width, height } = stage.getBoundingClientRect();
    const [across, down] = [width, height].map(side => Math.max(1, Math.round(side * scale)));
    Object.assign(canvas, { width: across, height: down });
    page.resize(across, down, scale);
    wake();
}

// A canvas keeps the context that it had; a new one gets a new device.
async function replaceCanvas() {
    const old = canvas;
    canvas = document.createElement('canvas');
    canvas.addEventListener('webglcontextlost', event => {
        event.preventDefault();
        if (event.target === canvas) replaceCanvas();
    });
    const scale = devicePixelRatio || 1;
    const { width, height } = stage.getBoundingClientRect();
    Object.assign(canvas, { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) });
    if (old) {
        losses += 1;
        page.lose_device();
        old.replaceWith(canvas);
        note('The graphics device was lost; another one draws now.');
    } else {
        stage.prepend(canvas);
    }
    for (let attempt = 0; ; attempt += 1) {
        try {
            document.body.dataset.device = await page.draw_into(canvas, wantsWebGl);
            return resize();
        } catch (error) {
            if (attempt === 5) {
                byId('still').hidden = false;
                return say('This browser offers no graphics (WebGPU or WebGL 2), so there is only a still picture.', String(error));
            }
            await new Promise(later => setTimeout(later, 400));
        }
    }
}

function place(event) {
    const { left, top } = stage.getBoundingClientRect();
    const scale = devicePixelRatio || 1;
    return [(event.clientX - left) * scale, (event.clientY - top) * scale];
}

function listen() {
    const on = (target, names, act) => names.split(' ').forEach(name => target.addEventListener(name, event => {
        if (!failed) act(event);
        wake();
    }, { passive: false }));
    const key = (event, down) => {
        const { key, code, repeat, ctrlKey, shiftKey, altKey, metaKey } = event;
        if (event.isComposing || event.target.closest?.('footer')) return;
        if (page.key(key, code, down, repeat, ctrlKey, shiftKey, altKey, metaKey) && down) event.preventDefault();
    };
    on(window, 'keydown', event => key(event, true));
    on(window, 'keyup', event => key(event, false));
    on(window, 'blur', () => page.blur());
    on(typing, 'input', event => {
        if (event.isComposing) return;
        if (event.inputType !== 'insertFromPaste') page.text(typing.value);
        typing.value = '';
    });
    on(typing, 'compositionupdate', event => page.compose(event.data));
    on(typing, 'compositionend', event => {
        page.compose('');
        page.text(event.data);
        typing.value = '';
    });
    on(window, 'paste', event => {
        if (takesText) page.text(event.clipboardData.getData('text/plain'));
    });
    const isFinger = event => event.pointerType === 'touch';
    const touch = (event, phase) => page.touch(event.pointerId, phase, ...place(event));
    on(stage, 'pointerdown', event => {
        event.preventDefault();
        stage.setPointerCapture(event.pointerId);
        if (!takesText) stage.focus({ preventScroll: true });
        if (isFinger(event)) return touch(event, 'down');
        if (holds && document.pointerLockElement !== stage) hold();
        page.pointer(...place(event), 0, 0);
        page.button(event.button, true);
    });
    on(stage, 'pointermove', event => {
        if (isFinger(event)) return touch(event, 'move');
        const scale = devicePixelRatio || 1;
        // A button beside another that is down comes as a move.
        if (event.button >= 0) page.button(event.button, (event.buttons & [1, 4, 2][event.button]) !== 0);
        page.pointer(...place(event), event.movementX * scale, event.movementY * scale);
    });
    on(stage, 'pointerup', event => {
        if (!isFinger(event)) return page.button(event.button, false);
        touch(event, 'up');
        // A keyboard on the screen opens only while the browser handles what the person did.
        tick();
    });
    on(stage, 'pointercancel', event => isFinger(event) ? touch(event, 'cancel') : page.blur());
    on(stage, 'contextmenu', event => event.preventDefault());
    on(stage, 'wheel', event => {
        event.preventDefault();
        const { deltaMode, deltaY, wheelDeltaY } = event;
        const isMouse = wheelDeltaY && wheelDeltaY % 120 === 0;
        page.wheel(isMouse ? wheelDeltaY / 120 : -deltaY / (deltaMode === 1 ? 3 : 40));
    });
    on(document, 'pointerlockchange', () => {
        if (holds && document.pointerLockElement !== stage) page.pointer_freed();
    });
    on(window, 'dragover', event => event.preventDefault());
    on(window, 'drop', event => {
        event.preventDefault();
        openFiles(event.dataTransfer.files);
    });
    on(window, 'hashchange', async () => {
        page.open_link(...await named(link()));
        wake();
    });
    on(byId('share'), 'click', share);
    on(byId('open'), 'click', () => byId('files').click());
    on(byId('files'), 'change', event => openFiles(event.target.files));
    on(byId('full'), 'click', () => document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen());
    new ResizeObserver(resize).observe(stage);
}

async function openFiles(list) {
    const files = [...list];
    const contents = await Promise.all(files.map(async file => new Uint8Array(await file.arrayBuffer())));
    page.open_files(files.map(file => file.name), contents);
    wake();
}

// The module, with words about how much of it is here.
async function module() {
    const answer = await fetch(new URL('./pkg/page_bg.wasm', import.meta.url));
    if (!answer.ok) throw new Error(`pkg/page_bg.wasm: ${answer.status} ${answer.statusText}`);
    const total = Number(document.body.dataset.bytes) || Infinity;
    let read = 0;
    const counted = new TransformStream({
        transform(chunk, to) {
            read += chunk.length;
            say(`Loading: ${Math.min(100, Math.floor(100 * read / total))} %`);
            to.enqueue(chunk);
        },
    });
    return new Response(answer.body.pipeThrough(counted), { headers: { 'content-type': 'application/wasm' } });
}

try {
    say('Loading');
    const bare = opened.has('bare');
    byId('bar').hidden = bare;
    await init({ module_or_path: await module() });
    const [[name, text, lesson], [own, left]] = [await named(opened), await drafts()];
    page = new Page(host, name, text, lesson, bare, innerWidth < 700 && matchMedia('(pointer: coarse)').matches, own, left);
    say('Starting');
    await replaceCanvas();
    listen();
    if (byId('still').hidden) say('');
    stage.focus({ preventScroll: true });
    wake();
    // For tests of the page.
    Object.assign(globalThis, { inertia: { page, canvas: () => canvas, losses: () => losses } });
} catch (error) {
    byId('still').hidden = false;
    say('The program could not be started.', String(error));
}
