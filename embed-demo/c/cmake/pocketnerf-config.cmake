# find_package(pocketnerf) gives pocketnerf::pocketnerf, the shared library, and
# pocketnerf::static.
get_filename_component(_pocketnerf_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
find_package(Threads REQUIRED)

if(NOT TARGET pocketnerf::pocketnerf)
    add_library(pocketnerf::pocketnerf SHARED IMPORTED)
    set_target_properties(pocketnerf::pocketnerf PROPERTIES
        IMPORTED_LOCATION "${_pocketnerf_prefix}/lib/${CMAKE_SHARED_LIBRARY_PREFIX}pocketnerf_c${CMAKE_SHARED_LIBRARY_SUFFIX}"
        INTERFACE_INCLUDE_DIRECTORIES "${_pocketnerf_prefix}/include")

    add_library(pocketnerf::static STATIC IMPORTED)
    set_target_properties(pocketnerf::static PROPERTIES
        IMPORTED_LOCATION "${_pocketnerf_prefix}/lib/libpocketnerf_c.a"
        INTERFACE_INCLUDE_DIRECTORIES "${_pocketnerf_prefix}/include"
        INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
endif()
