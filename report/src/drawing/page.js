// Opens the section that an address names, and all of them in print.
const show = () => document.getElementById(location.hash.slice(1))?.closest('details')?.setAttribute('open', '');
addEventListener('hashchange', show);
addEventListener('beforeprint', () => document.querySelectorAll('details').forEach(own => own.setAttribute('open', '')));
show();
