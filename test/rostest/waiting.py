"""What tests of live nodes wait for, with a bound that only what is broken reaches."""
import socket
import time
import xmlrpc.client

import rosgraph

PATIENCE_S = 60.0


def wait_for(condition, what, longest_s=PATIENCE_S):
    deadline = time.monotonic() + longest_s
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError("waited in vain for " + what)
        time.sleep(0.05)


def uri_of(node):
    """None before it is there. A node that was killed is there until it was started anew."""
    try:
        return rosgraph.Master("/waiting").lookupNode(node)
    except (rosgraph.MasterException, socket.error):
        return None


def sends(node, reader, *topics):
    """Whether all that `node` publishes on the topics from now on reaches `reader`."""
    uri = uri_of(node)
    try:
        links = xmlrpc.client.ServerProxy(uri).getBusInfo("/waiting")[2] if uri else []
    except (socket.error, xmlrpc.client.Error):
        return False
    return set(topics) <= {topic for _, to, way, _, topic, *_ in links if way == "o" and to == reader}


def wait_for_links(*links):
    """Each link is (node, reader, topic...)."""
    for link in links:
        wait_for(lambda: sends(*link), "the connections " + " ".join(link))
