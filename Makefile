# Any make will do: there is nothing of GNU's make here. GNU's rm and find are those of Linux.
# Everything runs through environment/run, which finds or builds an environment
# with dolfinx and all other tools; see "environment/run --help".

RUN := environment/run

# Runs a script of the verification report, and puts its tables there.
STUDY := $(RUN) python3 docs/verification.py

PICTURES := docs/pictures
LOOKS := results/looks
JOURNEYS := results/journeys

# Of the pictures that `fenics-nnm plot` makes of rotor 37, those shown in docs.
ROTOR37 := mesh.png mode_shapes.png motion.gif mode_shares.png harmonic_shares.png \
    frequency_gamma.png frequency_amplitude.png frequency_stress.png contact_map.png \
    distance_map.png footprint.png linear_modes.png \
    contact_force.png contact_duration.png phase_contact.png orbit.png certificate.png \
    multipliers_plane.png multipliers.png

.PHONY: help demo pictures journeys kinds test test-next lint clean distclean verify verify-studies \
    verify-random verify-fuzz verify-viewers look image image-check \
    docs docs-links dist

help:
	@echo 'make demo         run the demonstrations: the rod, then the blade of NASA rotor 37, at speed and at rest'
	@echo 'make pictures     make all pictures of the docs anew, in $(PICTURES)'
	@echo 'make test         run the tests and the checks of the source'
	@echo 'make test-next    run the tests with the packages of Debian unstable'
	@echo 'make verify       run the slow studies of docs/verification.md'
	@echo 'make look         look at reports in a browser, at the widths of a desktop and of a telephone'
	@echo 'make lint         run only the checks of the source'
	@echo 'make docs         build the docs as a site, links checked, in results/site/html'
	@echo 'make docs-links   look whether links to other sites still lead somewhere'
	@echo 'make dist         build sdist and wheel in dist/, and try them outside the checkout'
	@echo 'make image        build the container image fenics-nnm'
	@echo 'make image-check  build the image and run a small study in it'
	@echo 'make clean        remove caches and results'
	@echo 'make distclean    remove also the private environment in .environment/'

demo:
	$(RUN) python3 demos/rod/rod.py
	$(RUN) python3 demos/rotor37/engine.py
	$(RUN) python3 demos/rotor37/rotor37.py

pictures: demo
	cp demos/rod/results/backbone_exact.png $(PICTURES)/rod_backbone.png
	cp demos/rod/results/paper/backbone.png $(PICTURES)/rod_backbone_paper.png
	for name in phase_space space_time; do for rod in paper fine; do \
	    cp demos/rod/results/$${name}_$$rod.png $(PICTURES)/rod_$${name}_$$rod.png; done; done
	for name in backbone contact_shapes; do \
	    cp demos/rotor37/results/$$name.png $(PICTURES)/rotor37_$$name.png; done
	for name in $(ROTOR37); do \
	    cp demos/rotor37/results/pictures/$$name $(PICTURES)/rotor37_$$name; done
	cp demos/rotor37/results/engine/engine.png $(PICTURES)/rotor37_engine.png
	$(RUN) fenics-nnm campbell demos/rotor37/engine.toml --speeds 0:1800:300 \
	    --orders 1,2,3,4,6,8,12 --energies 0.3,0.6,1 --output demos/rotor37/results/campbell
	cp demos/rotor37/results/campbell/campbell.png $(PICTURES)/rotor37_campbell.png
	$(RUN) fenics-nnm response demos/rotor37/driven.toml --output demos/rotor37/results/driven
	cp demos/rotor37/results/driven/response.png $(PICTURES)/rotor37_driven.png
	$(RUN) fenics-nnm check demos/rotor37/rotor37.toml \
	    --picture $(PICTURES)/rotor37_groups.png
	$(RUN) python3 demos/plate/plate.py
	cp demos/plate/results/pressure.png $(PICTURES)/plate_pressure.png
	$(MAKE) kinds

# The pictures of the user guide: its three journeys.
journeys:
	rm -rf $(JOURNEYS)
	$(RUN) python3 demos/six_geometries.py step
	cp demos/step/results/groups.png $(PICTURES)/step_groups.png
	$(RUN) fenics-nnm response demos/step/driven.toml --output demos/step/results/driven
	cp demos/step/results/driven/response.png $(PICTURES)/step_driven.png
	for kind in blade matrices; do $(RUN) fenics-nnm new $$kind $(JOURNEYS) || exit; done
	$(RUN) fenics-nnm run $(JOURNEYS)/matrices.toml --output $(JOURNEYS)/matrices \
	    --set 'continuation.report_at=["1.2 mm"]'
	$(RUN) fenics-nnm run $(JOURNEYS)/blade.toml --output $(JOURNEYS)/blade \
	    --set 'continuation.amplitudes=["2 mm"]' --set 'continuation.report_at=["2.5 mm", "300 MPa"]'
	$(RUN) fenics-nnm run demos/step/damped.toml --output demos/step/results/damped \
	    --set continuation.energies.from=0.8 --set continuation.energies.step=0.05 \
	    --set mode.harmonics=60 --set mode.samples=512
	cp demos/step/results/damped/backbone.png $(PICTURES)/step_damped.png
	for kind in blade matrices; do \
	    $(RUN) fenics-nnm plot $(JOURNEYS)/$$kind --formats png || exit; done
	$(RUN) fenics-nnm sweep $(JOURNEYS)/blade.toml --set 'contact.gap="0.05 mm","0.1 mm","0.15 mm"' \
	    --set body.kinematics=linear,second-order --set 'continuation.report_at=[]' \
	    --gamma 2 --output $(JOURNEYS)/sweep
	cp $(JOURNEYS)/sweep/sweep.png $(PICTURES)/blade_sweep.png
	cp $(JOURNEYS)/blade/pictures/motion.gif $(PICTURES)/blade_motion.gif
	cp $(JOURNEYS)/matrices/pictures/frequency_gamma.png $(PICTURES)/matrices_frequency_gamma.png

# The gallery's bodies of other kinds; `journeys` leaves the results of demos/step.
kinds: journeys
	$(RUN) python3 demos/six_geometries.py inp shroud sector rotor67 fork
	for folder in step/results/blade inp/results/bracket shroud/results/shroud \
	    sector/results/sector rotor67/results/rotor67 fork/results/fork; do \
	    cp demos/$$folder/pictures/mode_shapes.png \
	        $(PICTURES)/$${folder%%/*}_mode_shapes.png || exit; done
	cp demos/sector/results/groups.png $(PICTURES)/sector_groups.png
	cp demos/rotor67/results/rotor67/pictures/frequency_gamma.png \
	    $(PICTURES)/rotor67_frequency_gamma.png

# One thread a process, as the tests take all cores.
test:
	OMP_NUM_THREADS=1 $(RUN) python3 -m pytest -q -n auto --dist worksteal tests
	$(MAKE) lint

# With the newest dolfinx that Debian has.
test-next:
	OMP_NUM_THREADS=1 environment/run --next python3 -m pytest -q -n auto --dist worksteal tests

# Four parts, side by side with "make -j 2 verify". Tables go into docs/verification.md.
verify: verify-studies verify-random verify-fuzz verify-viewers

verify-studies:
	$(STUDY) demos/rod/rod.py
	$(STUDY) demos/bilinear/bilinear.py
	$(STUDY) demos/rod/discretisations.py
	$(STUDY) demos/rod/automatic.py
	$(STUDY) demos/rod/zero_gap.py
	$(STUDY) demos/rod/preload.py
	$(STUDY) demos/plate/plate.py
	$(STUDY) tests/square_plate.py
	$(STUDY) tests/absorbing_rod.py
	$(STUDY) tests/rotating_bodies.py
	$(STUDY) tests/bending_bodies.py
	$(STUDY) tests/bending_in_time.py
	$(STUDY) tests/two_ranks.py
	$(STUDY) demos/six_geometries.py
	$(STUDY) demos/step/damped.py
	$(STUDY) demos/rotor37/mesh_study.py
	$(STUDY) demos/rotor37/reduction_study.py
	$(STUDY) demos/rotor37/certificate.py

verify-random:
	$(STUDY) tests/random_studies.py --count 200
	$(STUDY) tests/random_driven.py --count 20
	$(STUDY) tests/random_bent.py --count 60

# Hostile studies, damaged meshes and results, in two halves at a time.
verify-fuzz:
	$(RUN) python3 tests/fuzz.py --shard 2/2 & other=$$!; \
	    $(RUN) python3 tests/fuzz.py --shard 1/2; ended=$$?; wait $$other && exit $$ended

verify-viewers:
	$(RUN) fenics-nnm run tests/paraview/beam.toml --output results/paraview
	$(RUN) --viewers pvbatch tests/paraview/open_files.py results/paraview/fields
	$(MAKE) look

# Pages as they are seen in a browser, on a desktop and on a telephone.
look:
	for study in rod/paper rotor37/rotor37 shroud/shroud; do \
	    $(RUN) fenics-nnm run demos/$$study.toml --output $(LOOKS)/$$study && \
	    $(RUN) fenics-nnm report $(LOOKS)/$$study || exit; done
	$(RUN) --viewers python3 tests/look_at_pages.py $(LOOKS)/*/*/report.html --output $(LOOKS)/pages

# The pages and the reference of the Python face as a site; any warning is an error.
docs:
	environment/run --docs python3 docs/site/build.py

docs-links:
	environment/run --docs python3 docs/site/build.py linkcheck

lint:
	$(RUN) ruff check
	$(RUN) ruff format --check
	$(RUN) mypy fenics_nnm

dist:
	$(RUN) environment/wheel-check dist

image:
	environment/image-check --build-only

image-check:
	environment/image-check

clean:
	rm -rf build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache results
	find . -name .environment -prune -o -name __pycache__ -type d -exec rm -rf {} +

distclean: clean
	rm -rf --one-file-system .environment
