// A scene with everything built that paths need, for tests.
#pragma once

#include <utility>

#include "myrialux/emitters/emitters.h"
#include "myrialux/trace/tracer.h"
#include "myrialux/transport/paths.h"

namespace myrialux::test {

struct TestWorld {
  Scene scene;
  Tracer tracer;
  Emitters emitters;
  World world;
  explicit TestWorld(Scene s, int max_depth = -1)
      : scene(std::move(s)),
        tracer(scene),
        emitters(scene, tracer.bounds()),
        world{.scene = scene, .tracer = tracer, .emitters = emitters, .max_depth = max_depth} {}
  TestWorld(const TestWorld&) = delete;  // `world` refers to the members
};

}  // namespace myrialux::test
