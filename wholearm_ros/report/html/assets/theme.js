// Colours of the plots follow the page's, which follow the system's.
'use strict';
const dark = window.matchMedia('(prefers-color-scheme: dark)');
const colour = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const axisTheme = () => ({gridcolor: colour('line'), zerolinecolor: colour('line'), linecolor: colour('line')});
const plotTheme = () => ({paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
  font: {color: colour('ink'), family: 'system-ui, sans-serif', size: 12}});
const plotOptions = {responsive: true, displayModeBar: false, displaylogo: false};
