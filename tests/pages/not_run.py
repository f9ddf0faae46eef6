"""Blocks that are not run with their page: who does it instead, or what they are."""

ELSEWHERE = {
    ("docs/car-link.md", "class TextRadio"): (
        "a file beside the laboratory's: tests/live/test_car_link_page.py sends with it"
    ),
    ("docs/car-firmware.md", "import rclpy"): (
        "needs ROS 2: tests/live/test_car_link_page.py runs it with a stub for ROS"
    ),
    ("docs/car-firmware.md", "car_take"): (
        "C for a microcontroller: tests/live/test_car_link_page.py compiles and drives it"
    ),
    ("docs/behind-a-proxy.md", "proxy_pass"): (
        "a proxy's configuration: tests/browser/test_real_proxies.py has nginx take it"
    ),
    ("docs/behind-a-proxy.md", "reverse_proxy"): (
        "a proxy's configuration: tests/browser/test_real_proxies.py has Caddy take it"
    ),
    ("docs/laboratory-serving.md", "proxy_pass"): "a proxy's configuration: needs nginx",
    ("docs/tracking-source.md", "Feed(open_source"): (
        "a file that its child process imports: tests/live/test_tracking_page.py starts it"
    ),
    ("docs/tracking-source.md", "class Datagrams"): (
        "a file for app/live/sources/: tests/live/test_tracking_page.py streams from it"
    ),
}
"""Page, words of the block -> why it is not run here, and the test that does it."""

PRINTED = {
    ("docs/new-rule.md", "flockscope: rule 'fading'"): (
        "printed of a typing error: tests/test_new_rule.py makes it"
    ),
    ("docs/worlds.md", "yard.toml is sound"): "",
    ("docs/worlds-from-drawings.md", "flockscope: plan.dxf, layer 'WALLS'"): (
        "a refusal of a drawing that is not there: tests/worlds tests refusals"
    ),
    ("docs/worlds-from-drawings.md", "flockscope: house.dxf, layer 'A-WALL'"): (
        "a question about a drawing that is not there: tests/worlds/test_plan_walls.py asks it"
    ),
    ("docs/live-recordings.md", "sent last at"): (
        "printed of a killed loop: tests/live/test_while_driving.py kills one"
    ),
    ("docs/tracking.md", "unknown option 'port'"): (
        "a refusal: tests/live/test_tracking_page.py holds it against the code"
    ),
}
"""Page, beginning of a message -> why no command there prints it, "" if one does."""
