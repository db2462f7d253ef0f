"""The motion of a body in the page itself, to turn and to play: drawn by vtk.js in the browser."""
