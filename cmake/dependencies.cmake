# Finds the libraries and sets the flags common to all targets (target myrialux_flags).
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED)
endif()
find_package(hwy QUIET)
find_package(PkgConfig REQUIRED)
if(NOT hwy_FOUND)
  pkg_check_modules(hwy REQUIRED IMPORTED_TARGET libhwy)
  add_library(hwy::hwy ALIAS PkgConfig::hwy)
endif()
find_package(pugixml REQUIRED)
find_package(OpenImageIO REQUIRED)
# Debian's package names the headers of OpenCV, which it does not need and does not install.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER oiio_includes EXCLUDE REGEX "opencv")
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}"
  INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "")
find_package(OpenEXR REQUIRED)  # for its threads alone; pictures are written by OpenImageIO, which brings it
find_package(ZLIB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(Eigen3 3.4 REQUIRED)

add_library(myrialux_flags INTERFACE)
target_include_directories(myrialux_flags INTERFACE ${PROJECT_SOURCE_DIR}/src)
# Plain code is compiled for SSE4.2; kernels/ picks the instruction set at run time (Highway), Embree does its own.
# -Wrestrict misfires on "a" + std::to_string(b) in gcc 12 (its bug 105651).
# No contraction to fused multiply-add: the same bits from the same source on every machine.
target_compile_options(myrialux_flags INTERFACE -march=x86-64-v2 -ffp-contract=off -Wall -Wextra -Wshadow
  -Wno-psabi $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<BOOL:${MYRIALUX_WERROR}>:-Werror>)
target_compile_definitions(myrialux_flags INTERFACE MYRIALUX_VERSION="${PROJECT_VERSION}")
if(MYRIALUX_SANITIZE)
  target_compile_options(myrialux_flags INTERFACE -fsanitize=${MYRIALUX_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(myrialux_flags INTERFACE -fsanitize=${MYRIALUX_SANITIZE})
  if(MYRIALUX_SANITIZE STREQUAL "thread")
    set_source_files_properties(${PROJECT_SOURCE_DIR}/src/myrialux/base/loops.cpp
      PROPERTIES COMPILE_OPTIONS -fno-sanitize=thread)
  endif()
endif()

set(myrialux_libs_base TBB::tbb fmt::fmt)
set(myrialux_libs_kernels hwy::hwy)
set(myrialux_libs_completion Eigen3::Eigen)
set(myrialux_libs_scene pugixml::pugixml OpenImageIO::OpenImageIO ZLIB::ZLIB)
set(myrialux_libs_trace embree)
set(myrialux_libs_film OpenImageIO::OpenImageIO OpenEXR::OpenEXR)
set(myrialux_libs_report nlohmann_json::nlohmann_json)
