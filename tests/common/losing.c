/* A Vulkan driver that is another one until its device is lost, as a GPU's is that hangs: at call number PRISM_TEST_CALL
 * of the function PRISM_TEST_LOST. From then on whatever may say so answers VK_ERROR_DEVICE_LOST. */

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Function)(void);
typedef Function (*Lookup)(void *, const char *);
typedef int (*Call)(void *, void *, void *, void *, void *, void *);

static int calls, lost;

static void *driver(const char *name) {
    static void *library;
    if (!library) library = dlopen(getenv("PRISM_TEST_DRIVER"), RTLD_NOW | RTLD_LOCAL);
    return library ? dlsym(library, name) : NULL;
}

static Lookup device_functions;
static void *the_device;

static int loses(const char *name) {
    if (!lost && !strcmp(name, getenv("PRISM_TEST_LOST")) && ++calls >= atoi(getenv("PRISM_TEST_CALL"))) {
        /* What is lost runs no more, and reads nothing that is freed from now on. */
        ((int (*)(void *))device_functions(the_device, "vkDeviceWaitIdle"))(the_device);
        lost = 1;
    }
    return lost;
}

/* Six arguments at most, none of them a float: what a function does not take it does not look at. */
#define FUNCTION(name)                                                          \
    static Call real_##name;                                                    \
    static int name(void *a, void *b, void *c, void *d, void *e, void *f) {     \
        return loses(#name) ? -4 : real_##name(a, b, c, d, e, f);               \
    }
#define FUNCTIONS(each)                                                         \
    each(vkQueueSubmit2) each(vkWaitForFences) each(vkAcquireNextImageKHR)      \
    each(vkQueuePresentKHR) each(vkQueueWaitIdle) each(vkDeviceWaitIdle)
FUNCTIONS(FUNCTION)

static Function device_function(void *device, const char *name) {
    the_device = device;
    Function real = device_functions(device, name);
#define WRAPPED(known)                                                          \
    if (real && !strcmp(name, #known)) {                                        \
        real_##known = (Call)real;                                              \
        return (Function)known;                                                 \
    }
    FUNCTIONS(WRAPPED)
    return real;
}

Function vk_icdGetInstanceProcAddr(void *instance, const char *name) {
    Lookup functions = (Lookup)driver("vk_icdGetInstanceProcAddr");
    Function real = functions(instance, name);
    if (!real || strcmp(name, "vkGetDeviceProcAddr")) return real;
    device_functions = (Lookup)real;
    return (Function)device_function;
}

Function vk_icdGetPhysicalDeviceProcAddr(void *instance, const char *name) {
    return ((Lookup)driver("vk_icdGetPhysicalDeviceProcAddr"))(instance, name);
}

int vk_icdNegotiateLoaderICDInterfaceVersion(unsigned *version) {
    return ((int (*)(unsigned *))driver("vk_icdNegotiateLoaderICDInterfaceVersion"))(version);
}
