# Two commands do everything: `make demo` renders a real room, `make test` builds and runs all tests.
# The second run of either does no set-up again.
JOBS ?= $(shell nproc)
PRESET ?= release
BUILD = build/$(PRESET)

.PHONY: demo build test bench format check setup-build setup-test clean

demo: build
	@tools/demo.sh $(BUILD)/myrialux

build: setup-build $(BUILD)/build.ninja
	@cmake --build $(BUILD) --target myrialux -j $(JOBS)

test: setup-build setup-test $(BUILD)/build.ninja
	cmake --build $(BUILD) -j $(JOBS)
	@python3 tools/check_includes.py
	@tools/run_tests.sh $(BUILD)

# BENCH="--quick -o FILE" hands options on to tools/run_benchmarks.py.
bench: setup-build $(BUILD)/build.ninja
	cmake --build $(BUILD) -j $(JOBS)
	@tools/run_benchmarks.py $(BUILD) $(BENCH)

format:
	git ls-files '*.h' '*.cpp' | xargs clang-format -i

$(BUILD)/build.ninja: CMakeLists.txt cmake/folders.txt cmake/folders.cmake cmake/dependencies.cmake CMakePresets.json | setup-build
	@cmake --preset $(PRESET) >$(BUILD).log 2>&1 || cmake --preset $(PRESET)
	@touch $@

setup-build:
	@mkdir -p build
	@tools/setup.sh build

setup-test:
	@tools/setup.sh test
	@tools/setup_python.sh

clean:
	rm -rf build
