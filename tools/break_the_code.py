#!/usr/bin/env python3
"""Breaks the code on purpose, one small defect at a time, and asks whether the tests notice.

Works on a copy of the working tree (build/mutate/tree), never on the tree itself. Each defect is one replaced text, one
test program that is built with it, and the tests of it that must then fail:
  CAUGHT   they fail                     MISSED   they pass: a test is missing
  STALE    the text is not found exactly once, the code no longer compiles, or the tests do not run on sound code
Exit status 1 if any defect is MISSED or STALE. A first run compiles most of the library (ccache helps the next ones).

usage: tools/break_the_code.py [--list | --check] [-j N] [WORD ...]     WORD: only defects whose file or text contains it
--check builds nothing: it only asks whether every text is still found exactly once.
"""
import argparse
import collections
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TREE, BUILD = ROOT / "build/mutate/tree", ROOT / "build/mutate/build"
ENDLESS = 10  # a defect may turn a loop endless: no end within so many times the time of sound code counts as failing

# what is broken | file below src/myrialux | text | replacement | test program | tests that must fail
Defect = collections.namedtuple("Defect", "what file old new program tests")
DEFECTS = [Defect(*d) for d in [
    ("streams of two stages are the same", "base/rng.h",
     "key.pass | static_cast<std::uint32_t>(stage) << 24", "key.pass", "base", "Rng.*"),
    ("a box filter counts samples on an edge twice", "math/filter.cpp",
     "x >= -radius && x < radius", "x >= -radius && x <= radius", "math", "Filter.*"),
    ("points gather at one corner of a triangle", "math/warp.h",
     "const float root = std::sqrt(u.x);", "const float root = u.x;", "math", "Warp.*"),
    ("entries of weight 0 are drawn", "math/distribution.cpp",
     "std::upper_bound(", "std::lower_bound(", "math", "Distribution1D.*"),
    ("a word of 64 rows counts as empty", "matrix/bit_ops.h",
     "return n >= 64 ? ~std::uint64_t{0}", "return n > 64 ? ~std::uint64_t{0}", "matrix", "*BitMatrix*"),
    ("a face may name the vertex after the last", "scene/serialized.cpp",
     "if (v >= mesh.positions.size())", "if (v > mesh.positions.size())", "scene", "Serialized.*"),
    ("the loader takes an opacity of any size", "scene/mitsuba_bsdfs.cpp",
     '"opacity", 0.5f, {0, 1, false, "0 to 1"}', '"opacity", 0.5f, {0, 9, false, "0 to 1"}', "scene", "*BrokenScene*"),
    ("offsets forget the rounding of slivers", "scene/shape_point.cpp",
     "extent * sliver * stretch", "extent * stretch", "trace", "Offset.*-*Slow*"),
    ("offsets forget what an instance's transform rounds", "scene/shape_point.cpp",
     "constexpr double kPlacementUlps = 5;", "constexpr double kPlacementUlps = 0;", "trace", "Offset.*-*Slow*"),
    ("lanes that are off are traced", "trace/tracer.cpp",
     "lanes.on[k] = -static_cast<int>(valid >> k & 1);", "lanes.on[k] = -1;", "trace", "Packets.*"),
    ("all lanes share the first one's cut-outs", "trace/masks.cpp",
     "context->origin(lane), context->direction(lane)", "context->origin(lane), context->direction(0)", "trace",
     "Packets.*"),
    ("a varnish lets light in for nothing", "scattering/plastic.cpp",
     "coat_transmittance(bsdf, wi.z) * coat_transmittance(bsdf, wo.z)", "coat_transmittance(bsdf, wo.z)", "scattering",
     "Bsdf.IsReciprocal"),
    ("density of a metal's facets without the change of variables", "scattering/conductor.cpp",
     "alpha, wo, m) / (4 * dot(wi, m));", "alpha, wo, m) / (4 * wi.z);", "scattering",
     "Bsdf.WeightIsValueOverDensity"),
    ("Blinn-Phong lobes as (n + 8) / (8 pi), which reflects more than arrives", "scattering/blinn_phong.cpp",
     "(exponent + 2) * (exponent + 4) / (8 * kPi * (exponent + std::exp2(-0.5f * exponent)))",
     "(exponent + 8) / (8 * kPi)", "scattering", "BlinnPhong.*"),
    ("Blinn-Phong's half vectors count as directions", "scattering/blinn_phong.cpp",
     "p_gloss * pdf_half / (2 * length(wi + wo))", "p_gloss * pdf_half / 4", "scattering", "*BsdfChiSquare*blinnphong*"),
    ("MTL's Blinn-Phong may reflect more than 1", "scene/obj_scene.cpp",
     "material.specular.value = material.specular.value / gray(most);", "", "scene", "ObjScene.*"),
    ("refraction leaves radiance unscaled", "scattering/dielectric.cpp",
     "const float radiance_factor = 1 / (facet.eta * facet.eta);", "const float radiance_factor = 1;", "scattering",
     "Bsdf.WeightIsValueOverDensity"),
    ("polarisations are not averaged", "scattering/fresnel.cpp",
     "0.5f * (square(a_s) + square(a_p))", "square(a_s)", "scattering", "Fresnel.*"),
    ("density of a sphere's cone by its small-angle form", "emitters/area.cpp",
     "sine2 / (1 + std::sqrt(1 - sine2))", "sine2 / 2", "emitters", "Direct.*"),
    ("density of environments without the sine", "emitters/environment.cpp",
     "patches_.pdf_uv(at.uv) / (2 * kPi * kPi * at.sine)", "patches_.pdf_uv(at.uv) / (2 * kPi * kPi)", "emitters",
     "Direct.*"),
    ("lights are not divided by the probability of their emitter", "emitters/emitters.cpp",
     "area.radiance(on.at.uv) * (1 / (on.pdf_area * selection))", "area.radiance(on.at.uv) * (1 / on.pdf_area)",
     "emitters", "Emission.*"),
    ("the residual's MIS weight forgets the number of emitter samples", "transport/walk.cpp",
     "walk.light_samples * light_pdf_omega", "light_pdf_omega", "transport", "Residual.*"),
    ("the residual is not divided by the probability of its lobe", "transport/residual.cpp",
     "1 / sharp : missing / (1 - sharp)", "1 / sharp : missing", "reference", "*.InTheMean/VarnishedFloor"),
    ("what clamping takes away falls linearly", "transport/walk.h",
     "1 - (d * d) / (c * c)", "1 - d / c", "reference", "*.InTheMean/CornellBox"),
    ("receivers behind varnish are not divided by their probability", "receivers/receivers.cpp",
     "walk.beta * (1 / (1 - sharp))", "walk.beta", "receivers", "Receivers.*"),
    ("rays through a lens meet behind the focus plane", "receivers/camera.cpp",
     "centre * camera.focus_distance - on_lens", "centre * (camera.focus_distance * 1.1f) - on_lens", "receivers", "Lens.*"),
    ("all samples of a pixel are taken as the shutter opens", "receivers/camera.cpp",
     "share * (camera.shutter_close - camera.shutter_open)", "0 * share", "receivers", "Motion.*"),
    ("cameras turn the longer way round", "math/rigid_motion.cpp",
     "if (cosine < 0) {", "if (cosine > 0) {", "math", "RigidMotion.*"),
    ("pixels of a band draw the numbers of the first band", "methods/mdlc.cpp",
     "(receivers.first_sample + receivers.sample[first])", "receivers.sample[first]", "methods", "Mdlc.PixelsGivenInParts*"),
    ("roulette of light walks loses power", "lights/virtual_lights.cpp",
     "power = next * (1 / survival);", "power = next;", "lights", "VirtualLights.*"),
    ("light that arrives across smooth normals is not corrected", "lights/virtual_lights.cpp",
     "add_vertex(vertex, power * arrival, bounce", "add_vertex(vertex, power, bounce", "lights", "VirtualLights.*"),
    ("glossy lights use the shading cosine", "transfer/transfer.cpp",
     "std::fabs(dot(lights.ng[j], w) / wi.z)", "std::fabs(dot(lights.n[j], w) / wi.z)", "transfer", "Transfer.*"),
    ("active rows: only one of the light's normals counts", "kernels/active_bits.cpp",
     "lit = hn::And(hn::Lt(from_ng, zero), hn::Lt(from_n, zero));", "lit = hn::Lt(from_n, zero);", "kernels",
     "ActiveBits.*"),
    ("shadow rays start on the wrong side of the light", "kernels/shadow_ends.cpp",
     "light_offset, back)", "light_offset, w)", "kernels", "ShadowEnds.*"),
    ("clamped light is bounded by its distance, not its square", "kernels/shade_diffuse.cpp",
     "const V bound = hn::Set(d, inverse_squared_clamp(run.clamp_distance));",
     "const V bound = hn::Sqrt(hn::Set(d, inverse_squared_clamp(run.clamp_distance)));", "kernels", "*ShadeDiffuse*"),
    ("cut bounds take the nearest corner behind a plane", "kernels/cut_bounds.cpp",
     "hn::IfThenElse(hn::Lt(z, set(0)), far_squared,", "hn::IfThenElse(hn::Lt(z, set(0)), r.near_squared,",
     "clusters", "*ClusterBound*:CutBounds.*"),
    ("a bound leaves out the widest of the light cones", "clusters/bounds.cpp",
     "c.cone_cos = node.cone_cos, c.cone_sin = sine(node.cone_cos);", "c.cone_cos = 1, c.cone_sin = 0;", "clusters",
     "*ClusterBound*"),
    ("bounds of Blinn-Phong fall too fast", "clusters/lobe_bounds.cpp",
     "(1 - alpha2 * alpha2) / 6 : 0", "1.0f : 0", "clusters", "LobeBounds.*"),
    ("slices ignore normals", "clusters/slices.cpp",
     "m = receivers.n[i] * scale;", "m = receivers.n[i] * 0;", "clusters", "Slices.*"),
    ("representatives are drawn evenly", "clusters/tree_nodes.cpp",
     "rng.next() * node.importance < a.importance", "rng.next() < 0.5f", "clusters", "LightTree.*"),
    ("children of a split inherit all of the parent's light", "clusters/receiver_cut.cpp",
     "const float share = node.importance / divided.importance;", "const float share = 1 + 0 * divided.importance;", "clusters",
     "ReceiverCut.*"),
    ("columns are weighed by the number of their lights", "clusters/cut.cpp",
     "leaf ? 1.0f : tree.inner[place.node].importance / tree.importance[index(light)];",
     "leaf ? 1.0f : static_cast<float>(tree.inner[place.node].count);", "clusters", "LightCut.*"),
    ("rows found blocked keep an older bit", "visibility/slice_visibility.cpp",
     "visible[w] = (visible[w] & ~(std::uint64_t{p.valid[k]} << shift)) |", "visible[w] = visible[w] |", "visibility",
     "*SliceVisibilitySizes*"),
    ("rays to a fixed end start on their surface", "visibility/slice_visibility.cpp",
     "blocks[b].ng[k][row] * offsets[b].offset[row]", "blocks[b].ng[k][row] * 0", "visibility", "SliceVisibility*"),
    ("groups mix kinds of lights", "visibility/slice_visibility.cpp",
     "kind * 8 + octant(", "octant(", "visibility", "SliceVisibility.*"),
    ("complements match in any row", "completion/column_basis.cpp",
     "opposite &= all_known && differ == omega[w];", "opposite &= all_known && differ != 0;", "completion",
     "ColumnBasis.*"),
    ("columns match where they are not known", "completion/column_basis.cpp",
     "(omega[w] & ~known[w]) == 0", "true", "completion", "ColumnBasis.*"),
    ("copies are not verified", "completion/adaptive_columns.cpp",
     "if (((column[w] ^ bits_[w]) & pi_[w]) != 0) return false;",
     "if (((column[w] ^ bits_[w]) & pi_[w]) != 0) break;", "completion", "*Bamc*"),
    ("verification looks at sampled rows again", "completion/adaptive_columns.cpp",
     "checkable_[w] = active[w] & known_[w] & ~traced_[w];", "checkable_[w] = active[w] & known_[w];", "completion",
     "*Bamc*"),
    ("runs do not share out their weight", "completion/row_distribution.cpp",
     "add_to_rows(begin, w * 64 + bit, active, kOne / (n_runs * n_in_run));",
     "add_to_rows(begin, w * 64 + bit, active, kOne / n_runs);", "completion", "RowDistribution.*"),
    ("a varnished light is squeezed as if it were seen", "shading/fixed_lobes.cpp",
     "end == FixedEnd::source ? eta * eta : 1", "1", "shading", "*ShadeSlice.EveryEntry*"),
    ("rows of sharp Blinn-Phong keep what was scaled away", "shading/gather.cpp",
     "gathered.albedo[k] = diffuse_base(fixed.lobes);", "gathered.albedo[k] = params.reflectance * kInvPi;", "shading",
     "*ShadeSlice.EveryEntry*"),
    ("the film's blocks do not look beyond their rows", "film/accumulate.cpp",
     "sy < std::min(end_row, y_end + reach)", "sy < y_end", "film", "Accumulate.*"),
    ("peak memory is counted in the wrong unit", "report/stats.cpp",
     "return kib * 1024;", "return kib;", "report", "Stats.*"),
    ("variance of the mean as that of one pass", "reference/path_tracer.cpp",
     "squares[i] / (n * (n - 1))", "squares[i] / (n - 1)", "reference", "PathTracer.*"),
    ("the published method skips rows that face away", "methods/bamc.cpp",
     "{complete, params.bamc_cull, params.bamc_guard}", "{complete, true, params.bamc_guard}", "methods", "SliceMethods.*"),
    ("slices weigh clamping by tracked rows alone", "shading/shade.cpp",
     "removed * static_cast<double>(rows.size()) / n_tracked", "removed / n_tracked", "shading", "*ShadeSlice.ClampedAway*"),
    ("all passes draw the same numbers", "pipeline/pipeline.cpp",
     "return {params.seed, static_cast<std::uint32_t>(pass)};", "return {params.seed, pass < 0 ? 1u : 0u};",
     "pipeline", "Pipeline.*"),
    ("predicted memory forgets the receivers themselves", "pipeline/memory.cpp",
     "samples * (kReceiverBytes + kSampleBytes)", "samples * kSampleBytes", "apps", "MemoryLimit.HoldsForSmallFrames"),
    ("brute force leaves out every other chunk of lights", "methods/brute_force.cpp",
     "first += kBruteForceColumns", "first += 2 * kBruteForceColumns", "methods", "BruteForce.*"),
    ("illumination cuts look at the error alone, not at how dark receivers are", "methods/illumination_cut.cpp",
     "const float limit = error_ * point.colour,", "const float limit = error_,", "methods", "IlluminationCut.*"),
    ("one visible sample makes a whole pair visible", "visibility/pair_sampler.cpp",
     "samples.visible == samples.active) {", "samples.visible != 0) {", "visibility", "PairSampler.*"),
    ("two draws of a cluster count as twice its variance", "methods/pass_errors.cpp",
     "0.5 * difference * difference", "1.0 * difference * difference", "methods", "PassErrors.*"),
    ("lights of one walk count as independent", "methods/pass_errors.cpp",
     "squares += own * walk", "squares += own * own / d.weight + 0 * walk", "methods", "PassErrors.*"),
    ("drawn columns do not weigh for those not drawn", "clusters/refined_clusters.cpp",
     "drawn = {c.column, static_cast<float>(1 / probability)};", "drawn = {c.column, 1};", "clusters",
     "RefinedClusters.Draws*"),
    ("elimination leaves leading ones in earlier rows", "completion/gauss_jordan.cpp",
     "if (test_bit(at(r), lead)) add_to(at(r), row);", "", "completion", "GaussJordan.*:Spans.*"),
    ("wrong guesses are free", "completion/robust_pca.cpp",
     "error = r > step ? r - step : r < -step ? r + step : 0;", "error = r + 0 * step;", "completion", "RobustPca.*:MatrixSeparation.*"),
    ("copies replace traced bits", "completion/localized.cpp",
     "column_[w] |= predicted_[w] & active_[w] & ~traced_[w];", "column_[w] |= predicted_[w] & active_[w];", "completion",
     "Localized.*:*Completion*"),
    ("blocks are as far as their middle", "kernels/block_bounds.cpp",
     "hn::Max(hn::Sub(length, radius), set(0));", "length;", "visibility", "*BlockEnergies*"),
    ("shadows fall towards the light", "kernels/shadow_planes.cpp",
     "hn::CopySign(one, hn::Neg(side));", "hn::CopySign(one, side);", "visibility", "OccluderCache.*"),
    ("triangles with holes are remembered", "trace/tracer.cpp",
     "if (record.is_masked || record.is_null) return std::nullopt;", "", "visibility", "OccluderCache.*"),
    ("a pixel's error is that of one of its rows", "visibility/error_meter.cpp",
     "sum += draw_error(other, row, j);", "sum += other == row ? draw_error(other, row, j) : 0;", "visibility",
     "ErrorMeter.*"),
    ("the entry found wrong counts twice in its pixel", "visibility/error_meter.cpp",
     "!s_.active.test(row, j) || (row == known_row && j == known_column)",
     "!s_.active.test(row, j) || known_row + known_column + 1 == 0", "visibility", "ErrorMeter.*"),
    ("entries drawn by energy weigh as if drawn evenly", "visibility/error_meter.cpp",
     "kRowsByEnergy * error(row, j) / draw_.probability(row, j)",
     "kRowsByEnergy * error(row, j) * static_cast<double>(s_.columns.size())", "visibility", "ErrorMeter.*"),
    ("the pilot takes a slack that errs too much", "methods/slice_pilot.cpp",
     "const bool is_good = error <= limit;", "const bool is_good = error <= 4 * limit;", "methods", "VisibilityError.*"),
    ("slices that err too much stay as they are", "methods/slice_loop.cpp",
     "constexpr double kRedoneAbove = 3;", "constexpr double kRedoneAbove = 3e9;", "methods", "VisibilityError.*"),
    ("the meter's errors are shares of the pilot's radiance", "methods/slice_loop.cpp",
     "unit = frame_mean > 0 ? static_cast<double>(mean_radiance_) / frame_mean : 1;", "unit = 1;", "methods",
     "VisibilityError.*"),
    ("direct light counts fully beside the residual's path", "pipeline/local_light.cpp",
     "/*mis=*/params.residual", "/*mis=*/false", "pipeline", "Pipeline.*"),
]]


def copy_tree():
    """Brings the copy up to date with the working tree; files that are the same keep their time."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            check=True, capture_output=True, text=True).stdout
    wanted = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    for name in wanted:
        source, copy = ROOT / name, TREE / name
        if not copy.is_file() or copy.read_bytes() != source.read_bytes():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, copy)
    for path in list(TREE.rglob("*")):
        if path.is_file() and str(path.relative_to(TREE)) not in wanted:
            path.unlink()


def configure(programs, jobs):
    """Optimised a little and without asserts: the tests themselves must notice."""
    os.environ.setdefault("CCACHE_BASEDIR", str(ROOT))
    os.environ.setdefault("CCACHE_NOHASHDIR", "1")
    os.environ.setdefault("MYRIALUX_SCENES", str(ROOT.parent / "shared/scenes"))
    subprocess.run(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG", "-DMYRIALUX_BENCH=OFF"], check=True,
                   stdout=subprocess.DEVNULL)
    if not build(programs, jobs, subprocess.DEVNULL):
        sys.exit("the unbroken code does not build: cmake --build " + str(BUILD))


def build(programs, jobs, out=subprocess.DEVNULL):
    command = ["cmake", "--build", BUILD, "-j", str(jobs), "--target"] + ["test_" + p for p in programs]
    return subprocess.run(command, stdout=out, stderr=out).returncode == 0


def run_tests(defect, limit_s=None):
    """(all passed, number that passed, names of those that failed)"""
    program = BUILD / "tests" / ("test_" + defect.program)
    try:
        done = subprocess.run([program, "--gtest_filter=" + defect.tests, "--gtest_brief=1"], cwd=BUILD,
                              capture_output=True, text=True, errors="replace", timeout=limit_s)
    except subprocess.TimeoutExpired:
        return False, 0, [f"no end within {limit_s:.0f} s"]
    passed = re.search(r"\[  PASSED  \] (\d+) test", done.stdout)
    failed = list(dict.fromkeys(re.findall(r"\[  FAILED  \] ([^\s,]+)", done.stdout)))
    if done.returncode < 0:
        failed.append(f"signal {-done.returncode}")
    return done.returncode == 0, int(passed[1]) if passed else 0, failed


def occurrences(tree, defect):
    path = tree / "src/myrialux" / defect.file
    return path.read_text().count(defect.old) if path.is_file() else 0


def try_defect(defect, limit_s, jobs):
    """(verdict, remark)"""
    path, n = TREE / "src/myrialux" / defect.file, occurrences(TREE, defect)
    if n != 1:
        return "STALE", f"the text occurs {n} times"
    sound = path.read_text()
    path.write_text(sound.replace(defect.old, defect.new))
    try:
        if not build([defect.program], jobs):
            return "STALE", "does not compile"
        passes, _, failed = run_tests(defect, limit_s)
        return ("MISSED", "") if passes else ("CAUGHT", f"{len(failed)}: {failed[0]}" if failed else "exit status")
    finally:
        path.write_text(sound)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", metavar="WORD")
    parser.add_argument("--list", action="store_true", help="show the defects and end")
    parser.add_argument("--check", action="store_true", help="name the defects whose text is not found once, and end")
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    chosen = [d for d in DEFECTS if not options.words or any(w in d.file or w in d.what for w in options.words)]
    if options.list:
        for d in chosen:
            print(f"{d.file:32} {d.what}")
        return 0
    if options.check:
        counts = [(occurrences(ROOT, d), d) for d in chosen]
        for n, d in counts:
            if n != 1:
                print(f"STALE   {d.file}: {d.what}: the text occurs {n} times")
        return 0 if all(n == 1 for n, _ in counts) else 1
    begin = time.monotonic()
    copy_tree()
    configure(sorted({d.program for d in chosen}), options.jobs)
    print(f"{'verdict':8}{'time':>6}  defect", flush=True)
    counts, sound_runs = collections.Counter(), {}
    for defect in sorted(chosen, key=lambda d: d.program):  # by program: fewest rebuilds of sound code
        start = time.monotonic()
        key = defect.program, defect.tests
        if key not in sound_runs:
            build([defect.program], options.jobs)
            start_tests = time.monotonic()
            sound_runs[key] = *run_tests(defect), 60 + ENDLESS * (time.monotonic() - start_tests)
        passes, n_passed, _, limit_s = sound_runs[key]
        verdict, remark = try_defect(defect, limit_s, options.jobs) if passes and n_passed else (
            "STALE", f"on sound code test_{defect.program} {defect.tests} fails or runs no test")
        counts[verdict] += 1
        print(f"{verdict:8}{time.monotonic() - start:5.0f}s  {defect.file}: {defect.what}" + (remark and f"  [{remark}]"),
              flush=True)
    print(f"{counts['CAUGHT']} caught, {counts['MISSED']} missed, {counts['STALE']} stale; "
          f"{time.monotonic() - begin:.0f} s")
    return 0 if counts["CAUGHT"] == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
