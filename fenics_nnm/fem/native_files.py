"""Names of the files that a process and its worker exchange, in a folder of their own."""

from __future__ import annotations

#: The pickled job with its GiB; the mesh; the error, as JSON; all that was printed.
JOB, ANSWER, PROBLEM, LOG = "job", "answer.npz", "problem.json", "log"
