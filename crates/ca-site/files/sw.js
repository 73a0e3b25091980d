// Keeps the site for use without a network: all its files are fetched once, and a new version replaces them as a whole.

const NAME = "ca VERSION_OF_THE_SITE";
const FILES = ["FILES_OF_THE_SITE"];

addEventListener("install", event => {
  event.waitUntil(caches.open(NAME).then(cache => cache.addAll(FILES)).then(() => skipWaiting()));
});

addEventListener("activate", event => {
  const old = names => Promise.all(names.filter(name => name.startsWith("ca ") && name !== NAME).map(name => caches.delete(name)));
  event.waitUntil(caches.keys().then(old).then(() => clients.claim()));
});

addEventListener("fetch", event => {
  const address = new URL(event.request.url);
  if (event.request.method !== "GET" || address.origin !== location.origin) return;
  event.respondWith(caches.open(NAME)
    .then(cache => cache.match(event.request, { ignoreSearch: true }).then(found => found || (address.pathname.endsWith("/") && cache.match(new URL("index.html", address)))))
    .then(found => found || fetch(event.request)));
});
