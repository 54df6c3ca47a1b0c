"""A gateway as a process: it runs until it is told to stop, and says how it is."""

import asyncio
import logging
import signal
from functools import partial

from timonel.gateway.gateway import Gateway
from timonel.gateway.notify import notify, watchdog_interval

HEALTH_INTERVAL = 60.0  # s
FAILED = 70  # EX_SOFTWARE of sysexits.h

logger = logging.getLogger("timonel")


async def serve(gateway: Gateway) -> int:
    """Run `gateway` until SIGTERM, SIGINT or its own failure; the status to exit with.

    What is waiting to be sent has half a second to go. SIGUSR1 logs the counters, which come once a minute anyway.
    """
    loop = asyncio.get_running_loop()
    stop = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop.set)
    loop.add_signal_handler(signal.SIGUSR1, gateway.health.report)
    loop.set_exception_handler(_unexpected)
    routines = [
        loop.create_task(routine)
        for routine in (
            _open(gateway),
            _report_for_ever(gateway),
            _stay_alive(),
            _stop_when_failed(gateway, stop),
        )
    ]
    for routine in routines:
        routine.add_done_callback(partial(_stop_after_fault, stop))
    await stop.wait()
    notify("STOPPING=1")
    for routine in routines:
        routine.cancel()
    ends = await asyncio.gather(*routines, return_exceptions=True)
    await gateway.close()
    gateway.health.report()
    logger.info("stopped")
    for end in ends:
        if isinstance(end, Exception):
            raise end
    return FAILED if gateway.failed.is_set() else 0


async def _open(gateway: Gateway) -> None:
    await gateway.open()
    notify("READY=1")
    logger.info("running")


def _stop_after_fault(stop: asyncio.Event, routine: asyncio.Task[None]) -> None:
    if not routine.cancelled() and routine.exception() is not None:
        stop.set()


async def _report_for_ever(gateway: Gateway) -> None:
    while True:
        await asyncio.sleep(HEALTH_INTERVAL)
        gateway.health.report()


async def _stay_alive() -> None:
    interval = watchdog_interval()
    while interval is not None:
        notify("WATCHDOG=1")
        await asyncio.sleep(interval)


async def _stop_when_failed(gateway: Gateway, stop: asyncio.Event) -> None:
    await gateway.failed.wait()
    stop.set()


def _unexpected(_: asyncio.AbstractEventLoop, context: dict[str, object]) -> None:
    """What a link's own callback raised: log it as everything else is logged."""
    fault = context.get("exception")
    logger.error("%s", context["message"], exc_info=fault if isinstance(fault, BaseException) else None)
