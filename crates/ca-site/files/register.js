// Keeps the site for use without a network, where the browser can.
if ("serviceWorker" in navigator && window.isSecureContext && window === window.top) navigator.serviceWorker.register(new URL("sw.js", document.currentScript.src)).catch(() => undefined);
